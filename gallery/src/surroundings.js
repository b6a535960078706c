// A studio by formula, three softboxes in a dark room, and the prefiltered cube that three.js makes of it. It is the compiler's
// studio = "softboxes" (src/light/environment/studio.rs), so that its exact colours are those of the page's surroundings.
import {
  ClampToEdgeWrapping, DataTexture, DataUtils, EquirectangularReflectionMapping, HalfFloatType, LinearFilter, RepeatWrapping, Vector3,
} from "three";

/** Columns of the panorama: three.js makes a cube of it whose faces are a quarter as wide. */
const COLUMNS = 1024;
/** A pixel is the mean over this many places along each side. */
const PLACES = 2;

/** Place of a softbox, degrees from above and about it; its roll; tangents of half its angles; linear sRGB. */
const SOFTBOXES = [
  { theta: 52, phi: 128, roll: 12, half: [0.36, 0.24], radiance: [12, 11.6, 11] },
  { theta: 66, phi: 28, roll: -8, half: [0.1, 0.46], radiance: [4.7, 4.9, 5.1] },
  { theta: 40, phi: -62, roll: 25, half: [0.28, 0.13], radiance: [7, 7, 6.8] },
].map(({ theta, phi, roll, ...rest }) => {
  // here z is up
  const middle = direction(radians(theta), radians(phi), new Vector3());
  const across = new Vector3(0, 0, 1).cross(middle).normalize();
  const up = middle.clone().cross(across);
  return { middle, across, up, cos: Math.cos(radians(roll)), sin: Math.sin(radians(roll)), ...rest };
});
const KEY = SOFTBOXES[0].middle;

/**
 * The cube's levels are filtered by the lobe of GGX about the normal, alpha = roughness²; this is alpha over the spread. The blur of
 * an edge would be nearest to that by a Gaussian at 0.5, but the tails of GGX carry far: docs/integrating.md has what was measured.
 */
export const ALPHA_OF_SPREAD = 0.1;

/** Roughness of the studio behind the bodies: its cube is coarser than a screen. */
export const ROUGHNESS_BEHIND = 0.05;

/** Angle about the vertical from +x towards +z at which the first softbox stands. */
export const KEY_AZIMUTH = Math.atan2(KEY.y, KEY.x);

/** The prefiltered cube of the studio, `{ texture, lastLevel }`; `generator` is the renderer's `PMREMGenerator`. */
export function prefiltered(generator) {
  const panorama = studio();
  const { texture } = generator.fromEquirectangular(panorama);
  panorama.dispose();
  generator.dispose();
  return { texture, lastLevel: texture.mipmaps.length - 1 };
}

/** The equirectangular map as three.js reads it: y is up, columns go from -x over -z to +x, rows from below. */
function studio() {
  const rows = COLUMNS / 2;
  const texels = new Uint16Array(4 * COLUMNS * rows);
  const wi = new Vector3();
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < COLUMNS; column++) {
      const sum = [0, 0, 0];
      for (let place = 0; place < PLACES * PLACES; place++) {
        const part = (at) => (at + 0.5) / PLACES;
        const theta = Math.PI * (1 - (row + part(Math.floor(place / PLACES))) / rows);
        const phi = 2 * Math.PI * ((column + part(place % PLACES)) / COLUMNS - 0.5);
        radiance(direction(theta, phi, wi)).forEach((value, i) => (sum[i] += value / PLACES ** 2));
      }
      [...sum, 1].forEach((value, i) => (texels[4 * (row * COLUMNS + column) + i] = DataUtils.toHalfFloat(value)));
    }
  }
  const texture = new DataTexture(texels, COLUMNS, rows, undefined, HalfFloatType, EquirectangularReflectionMapping);
  [texture.wrapS, texture.wrapT] = [RepeatWrapping, ClampToEdgeWrapping];
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

function radiance(wi) {
  const softbox = SOFTBOXES.find(({ middle, across, up, cos, sin, half }) => {
    const ahead = wi.dot(middle);
    const [x, y] = [wi.dot(across) / ahead, wi.dot(up) / ahead];
    return ahead > 0 && Math.abs(cos * x + sin * y) < half[0] && Math.abs(cos * y - sin * x) < half[1];
  });
  if (softbox) return softbox.radiance;
  if (wi.z >= 0) {
    // a little lighter towards the first softbox
    const near = Math.max(0, wi.dot(KEY));
    return [0.05, 0.05, 0.053].map((wall) => wall * (0.7 + 0.9 * near * near));
  }
  // the floor, one unit below, lit where the first softbox hangs over it
  const pool = Math.exp(-0.35 * ((wi.x / -wi.z + 0.7) ** 2 + (wi.y / -wi.z - 0.9) ** 2));
  return [0.035 + 0.3 * pool, 0.032 + 0.28 * pool, 0.03 + 0.26 * pool];
}

function direction(theta, phi, to) {
  return to.set(Math.sin(theta) * Math.cos(phi), Math.sin(theta) * Math.sin(phi), Math.cos(theta));
}

function radians(degrees) {
  return (degrees * Math.PI) / 180;
}
