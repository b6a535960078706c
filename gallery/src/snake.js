// A snake in the manner of a corn snake: a tube along a coil, covered with overlapping keeled scales.
import { Vector3 } from "three";

/** Rows of scales around it, and the height of a scale's free end over the next in radii of the body. */
const ROWS = 18;
const RELIEF = 0.06;
/** Greatest angle of the microstructure across a scale, radians: it fans out. */
const FAN = 0.2;
const RADIUS = 0.2;
/** Length of a scale over its width. */
const SLENDER = 1.5;

/**
 * Its skin over (s, t): from head to tail, and around from the belly over the back. `rings` and `sides` are the vertices along
 * and around; without scales it is smooth.
 */
export function snake(rings, sides, hasScales) {
  const spots = spine(rings);
  const tube = spots.map((spot) => Array.from({ length: sides + 1 }, (_, side) => skin(spot, side / sides, 0)));
  return (s, t) => {
    const [ring, side] = [Math.round(s * rings), Math.round(t * sides)];
    // the seam's two columns see the same neighbours
    const [before, after] = [side === 0 ? sides - 1 : side - 1, side === sides ? 1 : side + 1];
    const tangent = tube[Math.min(ring + 1, rings)][side].clone().sub(tube[Math.max(ring - 1, 0)][side]).normalize();
    const around = tube[ring][after].clone().sub(tube[ring][before]).normalize();
    const normal = tangent.clone().cross(around).normalize();
    const { scales, girths } = spots[ring];
    const [height, along, across, beside] = hasScales ? relief(scales, t) : [0, 0, 0, 0];
    normal.addScaledVector(tangent, -along).addScaledVector(around, -across).normalize();
    tangent.addScaledVector(normal, -tangent.dot(normal)).normalize().applyAxisAngle(normal, 2 * beside * FAN);
    return { place: skin(spots[ring], t, height), normal, tangent, body: colour(girths, 2 * t - 1) };
  };
}

/** Height over the skin in radii, its slopes along and around the body, and the distance from the keel. */
function relief(scales, t) {
  const step = 0.02;
  const [column, steepest] = [t * ROWS, 1];
  const [height, beside] = scale(scales, column);
  const slope = (ahead, width) => {
    // a scale's width is a part of the girth; at its edge there is a step
    const rise = ((RELIEF * ROWS) / (2 * Math.PI * width)) * ((scale(...ahead)[0] - height) / step);
    return Math.min(steepest, Math.max(-steepest, rise));
  };
  return [RELIEF * height, slope([scales + step, column], SLENDER), slope([scales, column + step], 1), beside];
}

/** A coil that begins outside; with what is passed from the head to there: scales, and girths of the body. */
function spine(rings) {
  const centre = (s) => {
    const angle = 3.3 * Math.PI * s - 0.9;
    const radius = 1.13 - 0.86 * s;
    // about the middle of what is seen
    return new Vector3(radius * Math.cos(angle) - 0.09, radius * Math.sin(angle) - 0.12, 0);
  };
  let [scales, girths] = [0, 0];
  return Array.from({ length: rings + 1 }, (_, ring) => {
    const s = ring / rings;
    const ahead = centre(s + 1e-4).sub(centre(s - 1e-4)).normalize();
    const radius = RADIUS * girth(s);
    const spot = { centre: centre(s), side: new Vector3(-ahead.y, ahead.x, 0), radius, scales, girths };
    const step = centre(s + 1 / rings).sub(centre(s)).length();
    // scales keep their shape while the body is thick and do not shrink without end
    scales += step / ((SLENDER * 2 * Math.PI * Math.max(radius, 0.3 * RADIUS)) / ROWS);
    girths += step / (2 * Math.PI * RADIUS);
    return spot;
  });
}

/** Radius over the greatest one: a blunt snout, a head, a neck, a body, a pointed tail. */
function girth(s) {
  const snout = Math.sqrt(Math.max(0, 1 - Math.max(0, 1 - s / 0.03) ** 2));
  const head = 0.66 - 0.18 * smooth(0.05, 0.085, s);
  const body = head + 0.52 * smooth(0.09, 0.34, s);
  return Math.max(1e-3, snout * body * Math.min(1, (1 - s) / 0.55) ** 0.8);
}

/** A point of the skin: `t` from 0 on the belly over 0.5 on the back, `height` over it in radii. */
function skin({ centre, side, radius }, t, height) {
  const angle = 2 * Math.PI * (t - 0.5);
  const out = radius * (1 + height);
  // the belly is flat
  const up = Math.cos(angle) < 0 ? 0.6 : 0.9;
  return centre.clone().addScaledVector(side, out * Math.sin(angle)).add(new Vector3(0, 0, out * up * Math.cos(angle)));
}

/**
 * Height of the scales over the skin, 0 to 1, and the distance from the keel, -0.5 to 0.5 of a scale's width. Scales lie in rows
 * that are staggered by half a scale, each a tilted plate with its free end towards the tail; the highest plate shows.
 */
function scale(along, column) {
  let [best, keel] = [0, 0];
  for (let neighbour = -1; neighbour <= 1; neighbour++) {
    const row = Math.round(column) + neighbour;
    const beside = column - row;
    if (Math.abs(beside) > 0.75) continue;
    const stagger = row % 2 === 0 ? 0 : 0.5;
    const nearest = Math.round(along - stagger) + stagger;
    for (let number = -1; number <= 1; number++) {
      const behind = along - nearest - number;
      // pointed at the free end, 1.6 scales long and 1.5 wide
      const outline = (behind / 0.8) ** 2 + (beside / 0.75) ** 2;
      if (outline > 1) continue;
      const plate = 0.5 + 0.6 * behind - 0.5 * beside * beside;
      const ridge = 0.12 * Math.exp(-((beside / 0.1) ** 2)) * (1 - (behind / 0.8) ** 2);
      const height = (plate + ridge) * (1 - outline ** 6);
      if (height > best) [best, keel] = [height, Math.min(0.5, Math.max(-0.5, beside))];
    }
  }
  return [best, keel];
}

/** Saddles with dark rims on orange, a pale belly; linear. `along` in girths, `around` from -1 to 1, 0 on the back. */
function colour(along, around) {
  const red = [0.1, 0.014, 0.006];
  const black = [0.006, 0.004, 0.003];
  const orange = [0.21, 0.075, 0.022];
  const pale = [0.25, 0.21, 0.16];
  const saddle = blotch(along, around, 0, [0.3, 0.4]);
  // smaller ones on the sides, between them
  const inside = Math.min(saddle, blotch(along, Math.abs(around) - 0.58, 0.5, [0.17, 0.13]));
  const back = mix(mix(red, black, smooth(-0.24, -0.12, inside)), orange, smooth(-0.02, 0.07, inside));
  return mix(back, pale, smooth(0.74, 0.8, Math.abs(around)));
}

/** Below 0 inside of a row of squarish blotches with uneven outlines. */
function blotch(along, around, offset, [half, wide]) {
  const place = along / 0.5 + offset;
  const x = (place - Math.round(place)) / (half * (1 + 0.12 * Math.sin(7.3 * Math.round(place))));
  const uneven = 0.08 * Math.sin(31 * along + 3 * Math.sin(9 * around));
  return (x ** 4 + (around / wide) ** 4) ** 0.25 - 1 + uneven;
}

function smooth(from, to, x) {
  const t = Math.min(1, Math.max(0, (x - from) / (to - from)));
  return t * t * (3 - 2 * t);
}

function mix(a, b, t) {
  return a.map((value, i) => value + (b[i] - value) * t);
}
