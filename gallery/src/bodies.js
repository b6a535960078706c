// Bodies with normals, tangents (handedness in w) and body colours. Where a grating has grooves, they run across the tangent.
import { BufferAttribute, BufferGeometry, Vector3 } from "three";
import { snake } from "./snake.js";

/**
 * Bodies by name, coarse ones for pictures of few pixels; `map` is the square on which the BRDF map is drawn. A triangle costs at
 * least four pixels, however small it is.
 */
export const BODIES = { snake: wholeSnake, sphere, disc, map };

function wholeSnake(isCoarse) {
  const [rings, sides] = isCoarse ? [140, 20] : [480, 108];
  return grid(rings, sides, snake(rings, sides, !isCoarse));
}

function sphere(isCoarse) {
  const grey = [0.02, 0.02, 0.024];
  const rows = isCoarse ? 16 : 48;
  return grid(2 * rows, rows, (s, t) => {
    const [east, north] = [2 * Math.PI * s, Math.PI * (t - 0.5)];
    const normal = new Vector3(Math.cos(north) * Math.sin(east), Math.sin(north), Math.cos(north) * Math.cos(east));
    const tangent = new Vector3(Math.cos(east), 0, -Math.sin(east));
    return { place: normal.clone(), normal, tangent, body: grey };
  });
}

/** A compact disc: its track is nearly a circle, so the tangent is radial. */
function disc(isCoarse) {
  const grey = [0.011, 0.011, 0.013];
  return grid(isCoarse ? 64 : 160, isCoarse ? 1 : 8, (s, t) => {
    const angle = 2 * Math.PI * s;
    const tangent = new Vector3(Math.cos(angle), Math.sin(angle), 0);
    return { place: tangent.clone().multiplyScalar(1.05 - 0.8 * t), normal: new Vector3(0, 0, 1), tangent, body: grey };
  });
}

function map() {
  const tangent = new Vector3(1, 0, 0);
  return grid(1, 1, (s, t) => ({
    place: new Vector3(2 * s - 1, 2 * t - 1, 0),
    normal: new Vector3(0, 0, 1),
    tangent,
    body: [0, 0, 0],
  }));
}

/** A grid of quads over (s, t) in the unit square, counter-clockwise where tangent × bitangent is the normal. */
function grid(columns, rows, point) {
  const count = (columns + 1) * (rows + 1);
  const sizes = { position: 3, normal: 3, tangent: 4, body: 3 };
  const data = Object.fromEntries(Object.entries(sizes).map(([name, size]) => [name, new Float32Array(size * count)]));
  for (let i = 0; i < count; i++) {
    const { place, normal, tangent, body } = point((i % (columns + 1)) / columns, Math.floor(i / (columns + 1)) / rows);
    place.toArray(data.position, 3 * i);
    normal.toArray(data.normal, 3 * i);
    tangent.toArray(data.tangent, 4 * i);
    data.tangent[4 * i + 3] = 1;
    data.body.set(body, 3 * i);
  }
  const index = new Uint32Array(6 * columns * rows);
  for (let i = 0; i < columns * rows; i++) {
    const a = i + Math.floor(i / columns);
    const b = a + columns + 1;
    index.set([a, a + 1, b, b, a + 1, b + 1], 6 * i);
  }
  const geometry = new BufferGeometry();
  for (const [name, values] of Object.entries(data)) geometry.setAttribute(name, new BufferAttribute(values, sizes[name]));
  geometry.setIndex(new BufferAttribute(index, 1));
  return geometry;
}
