// Tables as textures of three.js: raw texels, nearest, no mipmaps, no colour space.
import {
  DataArrayTexture, DataTexture, FloatType, HalfFloatType, NearestFilter, NoColorSpace, RedFormat, RGBAFormat, RGFormat,
} from "three";
import { texel } from "./package.js";

const FORMATS = { 1: RedFormat, 2: RGFormat, 4: RGBAFormat };

/** Textures by the names that the function forms use. */
export function textures(tables) {
  return Object.fromEntries(tables.map((table) => [table.name, texture(table)]));
}

/** Directions of probes: row 0 to the light, row 1 to the viewer. */
export function directions(pairs) {
  const texels = new Float32Array(pairs.length * 8);
  pairs.forEach(([wi, wr], i) => {
    texels.set(wi, 4 * i);
    texels.set(wr, 4 * (pairs.length + i));
  });
  return texture({ isArray: false, format: "rgba32float", width: pairs.length, height: 2, bytes: texels.buffer });
}

function texture({ isArray, format, width, height, layers, bytes }) {
  const { channels, isHalf } = texel(format);
  const texels = isHalf ? new Uint16Array(bytes) : new Float32Array(bytes);
  const made = isArray ? new DataArrayTexture(texels, width, height, layers) : new DataTexture(texels, width, height);
  made.format = FORMATS[channels];
  made.type = isHalf ? HalfFloatType : FloatType;
  made.minFilter = made.magFilter = NearestFilter;
  made.generateMipmaps = false;
  made.flipY = false;
  made.unpackAlignment = 1;
  made.colorSpace = NoColorSpace;
  made.needsUpdate = true;
  return made;
}
