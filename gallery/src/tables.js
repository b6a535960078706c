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

/** Textures by the names that the function forms use. */
export function textures(tables) {
  return Object.fromEntries(tables.map((table) => [table.name, texture(table)]));
}

/**
 * Arguments of probes, a column each: the first vector with the number of its function in w; the viewer with the radius in w; the
 * other vectors.
 */
export function probeArguments(probes) {
  const texels = new Float32Array(probes.length * 20);
  probes.forEach(({ calls, vectors: [first, ...others], radius = 0, wr }, i) => {
    const rows = [[...first, Object.keys(CALLS).indexOf(calls)], [...wr, radius], ...others];
    rows.forEach((row, k) => texels.set(row, 4 * (k * probes.length + i)));
  });
  return texture({ isArray: false, format: "rgba32float", width: probes.length, height: 5, bytes: texels.buffer });
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
