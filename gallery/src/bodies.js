// Bodies with normals, tangents (handedness in w) and body colours. Where a grating has grooves, they run across the tangent.
import { BufferAttribute, BufferGeometry, Vector3 } from "three";

/** Bodies by name; `map` is the square on which the BRDF map is drawn. */
export const BODIES = { snake, sphere, disc, map };

function sphere() {
  const grey = [0.06, 0.06, 0.07];
  return grid(96, 48, (s, t) => {
    const [east, north] = [2 * Math.PI * s, Math.PI * (t - 0.5)];
    const normal = new Vector3(Math.cos(north) * Math.sin(east), Math.sin(north), Math.cos(north) * Math.cos(east));
    const tangent = new Vector3(Math.cos(east), 0, -Math.sin(east));
    return { place: normal.clone(), normal, tangent, body: grey };
  });
}

/** A compact disc: its track is nearly a circle, so the tangent is radial. */
function disc() {
  const grey = [0.04, 0.04, 0.045];
  return grid(160, 8, (s, t) => {
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

/** A tube swept along a coil, tangents along the body. */
function snake() {
  const step = 1e-3;
  return grid(560, 56, (s, t) => {
    const angle = 2 * Math.PI * t;
    const place = skin(s, angle);
    const [ahead, behind] = [Math.min(s + step, 1), Math.max(s - step, 0)];
    const tangent = skin(ahead, angle).sub(skin(behind, angle)).normalize();
    const around = skin(s, angle + step).sub(skin(s, angle - step));
    return { place, normal: tangent.clone().cross(around).normalize(), tangent, body: scales(s, angle) };
  });
}

/** The centre line: a coil that begins outside, where the head lies on the turn below. */
function spine(s) {
  const angle = 4.1 * Math.PI * s - 0.6;
  const radius = 1.12 - 0.82 * s;
  return new Vector3(radius * Math.cos(angle), radius * Math.sin(angle), 0.1 * Math.exp(-90 * s * s));
}

function skin(s, angle) {
  const ahead = spine(s + 1e-4).sub(spine(s - 1e-4)).normalize();
  const side = new Vector3(0, 0, 1).cross(ahead).normalize();
  const top = ahead.clone().cross(side);
  const radius = thickness(s);
  // flatter below and above than wide
  return spine(s)
    .addScaledVector(side, radius * Math.sin(angle))
    .addScaledVector(top, 0.85 * radius * Math.cos(angle));
}

function thickness(s) {
  const snout = Math.sqrt(Math.min(1, s / 0.016));
  const head = 0.035 * Math.exp(-(((s - 0.025) / 0.018) ** 2));
  const trunk = 0.075 + 0.075 * smooth(0.04, 0.3, s);
  const tail = Math.sqrt(Math.max(0, 1 - smooth(0.55, 1, s))) * 0.97 + 0.03 * (1 - s);
  return snout * (trunk + head) * tail + 1e-4;
}

/** Saddles with dark rims on orange, a pale belly: in the manner of a corn snake. Linear. */
function scales(s, angle) {
  const up = Math.cos(angle);
  const along = 30 * s;
  const saddle = Math.hypot((along - Math.round(along)) / 0.36, Math.sin(angle / 2) / 0.45);
  const red = [0.2, 0.028, 0.012];
  const black = [0.012, 0.008, 0.006];
  const orange = [0.42, 0.15, 0.045];
  const pale = [0.5, 0.42, 0.32];
  const back = mix(mix(red, black, smooth(0.78, 0.9, saddle)), orange, smooth(1.0, 1.15, saddle));
  return mix(pale, back, smooth(-0.75, -0.35, up));
}

function smooth(from, to, x) {
  const t = Math.min(1, Math.max(0, (x - from) / (to - from)));
  return t * t * (3 - 2 * t);
}

function mix(a, b, t) {
  return a.map((value, i) => value + (b[i] - value) * t);
}

/** A grid of quads over (s, t) in the unit square, counter-clockwise where tangent × bitangent is the normal. */
function grid(columns, rows, point) {
  const data = { position: [], normal: [], tangent: [], body: [] };
  for (let j = 0; j <= rows; j++) {
    for (let i = 0; i <= columns; i++) {
      const { place, normal, tangent, body } = point(i / columns, j / rows);
      data.position.push(place.x, place.y, place.z);
      data.normal.push(normal.x, normal.y, normal.z);
      data.tangent.push(tangent.x, tangent.y, tangent.z, 1);
      data.body.push(...body);
    }
  }
  const index = [];
  for (let j = 0; j < rows; j++) {
    for (let i = 0; i < columns; i++) {
      const a = j * (columns + 1) + i;
      const b = a + columns + 1;
      index.push(a, a + 1, b, b, a + 1, b + 1);
    }
  }
  const geometry = new BufferGeometry();
  for (const [name, values] of Object.entries(data)) {
    const size = name === "tangent" ? 4 : 3;
    geometry.setAttribute(name, new BufferAttribute(new Float32Array(values), size));
  }
  geometry.setIndex(index);
  return geometry;
}
