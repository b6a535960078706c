// What shines on the bodies, and the functions of a variant that know it. All lights but the studio have the same irradiance.
import { Vector3 } from "three";
import { KEY_AZIMUTH } from "./surroundings.js";

/**
 * Functions that a variant may offer, and their arguments in the shells: `a` is the direction or the axis, or a corner with `b` to `d`;
 * `radius` is that of a disc, or a spread.
 */
export const CALLS = {
  diffraction: "a, wr",
  diffraction_disc: "a, radius, wr",
  diffraction_rectangle: "a, b, c, d, wr",
  diffraction_environment: "wr",
  diffraction_spread: "a, wr, radius",
  diffraction_disc_coloured: "a, radius, tint, wr",
  diffraction_rectangle_coloured: "a, b, c, d, tint, wr",
};

/** The function that takes light from all around, by an `environment_radiance` of the shell. */
export const AROUND = "diffraction_environment";

/** A single direction with wider lobes. Discs are lobes of it where a variant has no function for them. */
export const SPREAD = "diffraction_spread";

/** The function that draws a light: that of its kind, by a wider lobe where the variant has those. */
export const drawnBy = (name, variant) =>
  ["diffraction", "diffraction_disc"].includes(LIGHTS[name].calls) && variant.signature(SPREAD) ? SPREAD : LIGHTS[name].calls;

/**
 * In both languages, the spread of a pixel's footprint and of a disc, from `path`, (u, v), `viewer`, and `radius` and `cosine` of the disc. As in
 * `footprint_spread` of whole shaders: 1.5 times the longest step of (u, v) between pixels, at most half of the lower height of light and
 * viewer. A disc is a lobe with the variance sin² a cos θ/4.
 */
export const widened = ([vec2, let_], right, down) => `
    ${let_("path_x", vec2)} = ${right}(path);
    ${let_("path_y", vec2)} = ${down}(path);
    ${let_("steps")} = dot(path_x, path_x) + dot(path_y, path_y);
    ${let_("area")} = path_x.x * path_y.y - path_x.y * path_y.x;
    ${let_("height")} = max(min(cosine, sqrt(max(1.0 - dot(viewer, viewer), 0.0))), 0.0);
    ${let_("steps_squared")} = 0.5 * (steps + sqrt(max(0.0, steps * steps - 4.0 * area * area)));
    ${let_("variance")} = min(2.25 * steps_squared, 0.25 * height * height);
    ${let_("lobe_size")} = sqrt(variance + 0.25 * sin(radius) * sin(radius) * max(cosine, 0.0));`;

/** The function with the same arguments that returns XYZ. */
export const tristimulus = (name) => name.replace("diffraction", "tristimulus");

/**
 * Lights by their names in the address, the first one is the default: words, function, the sizes that a visitor chooses. Sizes are
 * angles in degrees, as seen from the bodies.
 */
export const LIGHTS = {
  sun: { words: "sun, 0.53°", calls: "diffraction_disc", sizes: [], diameter: 0.53 },
  lamp: { words: "lamp", calls: "diffraction_disc", sizes: ["diameter"] },
  softbox: { words: "softbox", calls: "diffraction_rectangle", sizes: ["width", "height"] },
  studio: { words: "studio, all around", calls: AROUND, sizes: [] },
  direction: { words: "single direction", calls: "diffraction", sizes: [] },
};

/** Functions that a variant offers. */
export function functionsOf(variant) {
  return Object.keys(CALLS).filter((name) => variant.signature(name));
}

/** Names of the lights that a variant has the functions for. */
export function lightsOf(variant) {
  return Object.keys(LIGHTS).filter((name) => variant.signature(drawnBy(name, variant)));
}

/**
 * Uniforms of a light. `light` is the unit vector to its middle, `sizes` holds degrees, `diffuser` is the variant's scale under a
 * single direction. `scale` makes radiance relative to that of a white diffuser which faces the light; `reach` is the sine of
 * the angle from the middle to the farthest edge. `turn` holds cosine and sine of the angle by which the studio is turned, so that
 * its greatest softbox stands where the light is, seen from above.
 */
export function uniformsOf(name, light, sizes, diffuser, calls = LIGHTS[name].calls) {
  const point = { light, light_a: light, light_b: light, light_c: light, light_d: light, radius: 0, reach: 0, scale: diffuser, turn: new Vector3(1, 0, 0) };
  if (LIGHTS[name].calls === "diffraction") return point;
  if (LIGHTS[name].calls === AROUND) {
    const angle = Math.atan2(light.z, light.x) - KEY_AZIMUTH;
    return { ...point, scale: 1, turn: new Vector3(Math.cos(angle), Math.sin(angle), 0) };
  }
  if (LIGHTS[name].calls === "diffraction_disc") {
    const radius = radians(LIGHTS[name].diameter ?? sizes.diameter) / 2;
    // the narrowest lobes are those of the sun
    if (calls === SPREAD) return { ...point, radius: LIGHTS[name].diameter ? 0 : radius };
    return { ...point, radius, reach: Math.sin(radius), scale: Math.PI };
  }
  const corners = rectangle(light, radians(sizes.width), radians(sizes.height));
  const [light_a, light_b, light_c, light_d] = corners;
  const reach = Math.sqrt(1 - light.dot(light_a) ** 2);
  return { ...point, light_a, light_b, light_c, light_d, reach, scale: Math.PI / irradiance(corners, light) };
}

/** The uniforms of any light, as a renderer makes them of values. */
export function lightUniforms(make) {
  const first = Object.entries(uniformsOf("direction", new Vector3(0, 0, 1), {}, 1));
  return Object.fromEntries(first.map(([name, value]) => [name, make(value.isVector3 ? value.clone() : value)]));
}

/** Unit vectors to the corners of an upright rectangle that faces the bodies, of angles seen across its middle. */
function rectangle(middle, width, height) {
  const up = Math.abs(middle.y) < 0.999 ? new Vector3(0, 1, 0) : new Vector3(0, 0, -1);
  const right = up.cross(middle).normalize().multiplyScalar(Math.tan(width / 2));
  const above = middle.clone().cross(right).normalize().multiplyScalar(Math.tan(height / 2));
  const corner = (x, y) => middle.clone().addScaledVector(right, x).addScaledVector(above, y).normalize();
  return [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)];
}

/** Irradiance of a plane under a polygon of radiance 1 above it (Lambert's formula). */
function irradiance(corners, normal) {
  const edges = corners.map((from, i) => {
    const to = corners[(i + 1) % corners.length];
    return from.angleTo(to) * from.clone().cross(to).normalize().dot(normal);
  });
  return edges.reduce((sum, edge) => sum + edge) / 2;
}

function radians(degrees) {
  return (degrees * Math.PI) / 180;
}
