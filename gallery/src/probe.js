// The package's probes against what an integration computes, and wrong integrations that they must catch.
import { AROUND } from "./lights.js";
import { listVariants, loadProbes, loadVariant } from "./package.js";

const SWAPPED = "swapped channels";
const FLIPPED = "flipped bitangent";
const RESIZED = "another size of the light";
const BLURRED = "a spread taken for degrees";
const TURNED = "mirrored surroundings";

/** Pixels of a row that drivers give back together. */
const BLOCK = 16;

/** [`probeVariant`] for all variants. */
export async function probePackage(files, engine, target) {
  const results = [];
  for (const place of await listVariants(files)) results.push(await probeVariant(files, engine, target, place));
  return results;
}

/**
 * Evaluates the probes of a variant: `worst` is the greatest error over its tolerance, `controls` the same for wrong
 * integrations, of the function that shows the fault least.
 */
export async function probeVariant(files, engine, target, place) {
  const variant = await loadVariant(files, place, target);
  const probes = await loadProbes(files, place);
  const functions = {};
  for (const { calls } of probes) functions[calls] = (functions[calls] ?? 0) + 1;
  const missing = Object.keys(functions).find((name) => !variant.signature(name));
  if (missing) throw new Error(`${place.folder}: probe.json has ${missing}, the function form for ${target} does not`);
  // one shader, compiled once
  const all = [probes, ...[mirrored, resized, blurred, turned].map((wrong) => probes.map(wrong))].flat();
  while (all.length % BLOCK) all.push(probes[0]);
  const pixels = await engine.probe(variant, all);
  const part = (from) => probes.map((_, i) => [0, 1].map((row) => {
    const start = 4 * (all.length * row + from * probes.length + i);
    return [...pixels.subarray(start, start + 3)];
  }));
  const [seen, flipped, resizedSeen, blurredSeen, turnedSeen] = [0, 1, 2, 3, 4].map(part);
  const swapped = seen.map((colours) => colours.map(([x, y, z]) => [z, y, x]));
  const names = Object.keys(functions);
  const least = (wrong, of) => Math.min(...of.map((name) => worst(wrong, probes, name)));
  const controls = { [SWAPPED]: least(swapped, names), [FLIPPED]: least(flipped, names) };
  const sized = names.filter((name) => name !== "diffraction" && name !== AROUND);
  if (sized.length > 0) controls[RESIZED] = least(resizedSeen, sized);
  if (names.includes(AROUND)) {
    controls[BLURRED] = least(blurredSeen, [AROUND]);
    controls[TURNED] = least(turnedSeen, [AROUND]);
  }
  const greatest = Math.max(...names.map((name) => worst(seen, probes, name)));
  return { surface: place.surface, variant: place.variant, count: probes.length, functions, worst: greatest, controls };
}

/** XYZ in the studio of a variant that has the function, towards unit vectors to viewers in a tangent frame whose normal is up. */
export async function probeStudio(files, engine, target, place, viewers) {
  const variant = await loadVariant(files, place, target);
  const all = viewers.map((wr) => ({ calls: AROUND, vectors: [], wr }));
  while (all.length % BLOCK) all.push(all[0]);
  const pixels = await engine.probe(variant, all, true);
  return viewers.map((_, i) => [...pixels.subarray(4 * i, 4 * i + 3)]);
}

/** A probe under a flipped bitangent. */
function mirrored(probe) {
  return { ...turned(probe), vectors: probe.vectors.map(flip), wr: flip(probe.wr) };
}

/** A probe whose sky is its own mirror image. */
function turned({ sky, ...rest }) {
  return { ...rest, sky: sky && { ...sky, lobes: sky.lobes.map((lobe) => ({ ...lobe, axis: flip(lobe.axis) })) } };
}

/** A probe whose sky is blurred far too much. Without any blur it would pass: the lobes of its skies are wide. */
function blurred(probe) {
  return { ...probe, spreadFactor: 180 / Math.PI };
}

function flip([x, y, z]) {
  return [x, -y, z];
}

/** A probe under a wider disc, or under a quadrilateral that has lost a corner. */
function resized(probe) {
  const [a, b, c] = probe.vectors;
  return { ...probe, radius: 1.5 * probe.radius, vectors: c ? [a, b, c, c] : probe.vectors };
}

/**
 * The greatest difference over its tolerance among the probes of a function: XYZ, and RGB, whose matrix has rows of at most 5.3
 * in sum of moduli. What is not a number counts as infinite.
 */
function worst(seen, probes, name) {
  const ratios = probes.flatMap(({ calls, expected, tolerance }, i) =>
    calls !== name ? [] : [expected.xyz, expected.rgb].flatMap((colour, row) =>
      colour.map((value, channel) => Math.abs(seen[i][row][channel] - value) / (tolerance * (row === 0 ? 1 : 5.3))),
    ),
  );
  const greatest = Math.max(...ratios);
  return Number.isFinite(greatest) ? greatest : Number.MAX_VALUE;
}
