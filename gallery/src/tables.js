// Tables as textures of three.js: raw texels, no mipmaps, no colour space.
import {
  DataArrayTexture, DataTexture, FloatType, HalfFloatType, LinearFilter, NearestFilter, NoColorSpace, RGBAFormat, RGBFormat,
  RGFormat, UnsignedInt5999Type,
} from "three";
import { CALLS } from "./lights.js";

/** By WebGPU's names: format and type of three.js, and the array that holds texels. */
const FORMATS = {
  rg16float: [RGFormat, HalfFloatType, Uint16Array],
  rgba16float: [RGBAFormat, HalfFloatType, Uint16Array],
  rg32float: [RGFormat, FloatType, Float32Array],
  rgba32float: [RGBAFormat, FloatType, Float32Array],
  rgb9e5ufloat: [RGBFormat, UnsignedInt5999Type, Uint32Array],
};

/** Row of a sky among the arguments of probes, and the lobes that it may have. */
export const SKY_ROW = 5;
export const SKY_LOBES = 2;

/** Textures by the names that the function forms use. */
export function textures(tables) {
  return Object.fromEntries(tables.map((table) => [table.name, texture(table)]));
}

/**
 * Arguments of probes, a column each: the first vector with the number of its function in w; the viewer with the radius in w; the
 * other vectors, with the colour in w; and a sky: its constant part, with a factor on the spread in w, then for each lobe the axis with its width in w, and
 * the radiance.
 */
export function probeArguments(probes) {
  const height = SKY_ROW + 1 + 2 * SKY_LOBES;
  const texels = new Float32Array(probes.length * height * 4);
  probes.forEach(({ calls, vectors: [first = [0, 0, 1], ...others], radius = 0, colour = [0, 0, 0], sky, spreadFactor = 1, wr }, i) => {
    const set = (row, k) => texels.set(row, 4 * (k * probes.length + i));
    const further = colour.map((share, k) => [...(others[k] ?? first), share]);
    [[...first, Object.keys(CALLS).indexOf(calls)], [...wr, radius], ...further].forEach(set);
    const { constant, lobes } = sky ?? { constant: [0, 0, 0], lobes: [] };
    if (lobes.length > SKY_LOBES) throw new Error(`a probe's sky has ${lobes.length} lobes, here it may have ${SKY_LOBES}`);
    set([...constant, spreadFactor], SKY_ROW);
    for (let k = 0; k < SKY_LOBES; k++) {
      // of no light where there is no lobe
      const { axis, sigma, radiance } = lobes[k] ?? { axis: [0, 0, 1], sigma: 1, radiance: [0, 0, 0] };
      set([...axis, sigma], SKY_ROW + 1 + 2 * k);
      set(radiance, SKY_ROW + 2 + 2 * k);
    }
  });
  return texture({ isArray: false, format: "rgba32float", width: probes.length, height, bytes: texels.buffer });
}

function texture({ isArray, isFiltered, format, width, height, layers, bytes }) {
  if (!FORMATS[format]) throw new Error(`${format}: not a format of tables`);
  const [channels, type, Numbers] = FORMATS[format];
  const texels = new Numbers(bytes);
  const made = isArray ? new DataArrayTexture(texels, width, height, layers) : new DataTexture(texels, width, height);
  made.format = channels;
  made.type = type;
  made.minFilter = made.magFilter = isFiltered ? LinearFilter : NearestFilter;
  made.generateMipmaps = false;
  made.flipY = false;
  made.unpackAlignment = 1;
  made.colorSpace = NoColorSpace;
  made.needsUpdate = true;
  return made;
}
