// The package's probes against what an integration computes, and wrong integrations that they must catch.
import { listVariants, loadProbes, loadVariant } from "./package.js";

const SWAPPED = "swapped channels";
const FLIPPED = "flipped bitangent";

/** [`probeVariant`] for all variants. */
export async function probePackage(files, engine, target) {
  const results = [];
  for (const place of await listVariants(files)) results.push(await probeVariant(files, engine, target, place));
  return results;
}

/**
 * Evaluates the probes of a variant: `worst` is the greatest error over its tolerance, `controls` the same for wrong
 * integrations.
 */
export async function probeVariant(files, engine, target, place) {
  const variant = await loadVariant(files, place, target);
  const probes = await loadProbes(files, place);
  const pairs = probes.map(({ wi, wr }) => [wi, wr]);
  const mirrored = pairs.map((pair) => pair.map(([x, y, z]) => [x, -y, z]));
  // two rows, XYZ and RGB, of the probes and then of their mirror images: one shader, compiled once
  const both = await engine.probe(variant, [...pairs, ...mirrored]);
  const part = (from) => [0, 1].flatMap((row) => {
    const start = 4 * (2 * row + from) * pairs.length;
    return [...both.subarray(start, start + 4 * pairs.length)];
  });
  const [pixels, flipped] = [part(0), part(1)];
  const swapped = pixels.slice();
  for (let i = 0; i < pixels.length; i += 4) [swapped[i], swapped[i + 2]] = [pixels[i + 2], pixels[i]];
  const controls = { [SWAPPED]: worst(swapped, probes), [FLIPPED]: worst(flipped, probes) };
  return { surface: place.surface, variant: place.variant, count: probes.length, worst: worst(pixels, probes), controls };
}

/**
 * The greatest difference over its tolerance: XYZ, and RGB, whose matrix has rows of at most 5.3 in sum of moduli. What is
 * not a number counts as infinite.
 */
function worst(pixels, probes) {
  const ratios = probes.flatMap(({ expected, tolerance }, i) =>
    [expected.xyz, expected.rgb].flatMap((colour, row) =>
      colour.map((value, channel) => {
        const seen = pixels[4 * (row * probes.length + i) + channel];
        return Math.abs(seen - value) / (tolerance * (row === 0 ? 1 : 5.3));
      }),
    ),
  );
  const greatest = Math.max(...ratios);
  return Number.isFinite(greatest) ? greatest : Number.MAX_VALUE;
}
