// The function form of WGSL behind three.js's WebGPURenderer, as a node of its shading language.
import { FloatType, LinearSRGBColorSpace, NearestFilter, NoBlending, NoToneMapping, RenderTarget, Vector3 } from "three";
import { attribute, cubeTexture, positionGeometry, sampler, screenCoordinate, texture, uniform, varying, wgsl, wgslFn } from "three/tsl";
import { NodeMaterial, PMREMGenerator, QuadMesh, WebGPURenderer } from "three/webgpu";
import { AROUND, CALLS, functionsOf, lightUniforms, SPREAD, tristimulus, widened } from "./lights.js";
import { ALPHA_OF_SPREAD, prefiltered, ROUGHNESS_BEHIND } from "./surroundings.js";
import { probeArguments, SKY_LOBES, SKY_ROW, textures } from "./tables.js";

export const target = "wgsl";

/**
 * Radiance of three.js's prefiltered cube, from a direction of the world, blurred as by that roughness. The package's text calls its
 * host without textures: so this reads a binding by the name that its node gives it, and the place from private variables.
 */
const AROUND_TEXT = `fn engine_around(to: vec3f, roughness: f32) -> vec3f {
    let turned = vec3f(engine_turn.x * to.x + engine_turn.y * to.z, to.y, engine_turn.x * to.z - engine_turn.y * to.x);
    // three.js has cubes of render targets mirrored in x on WebGPU
    let at = vec3f(-turned.x, turned.yz);
    return textureSampleLevel(engine_surroundings, engine_surroundings_sampler, at, engine_last_level * roughness * (2.0 - roughness)).rgb;
}`;
const AROUND_STATE = `var<private> engine_turn: vec3f;
var<private> engine_last_level: f32;
var<private> engine_frame: mat3x3f;
`;

/** What `diffraction_environment` asks for. The frame is that of the place, tangent to world. */
const HOST = `fn environment_radiance(direction: vec3f, spread: f32) -> vec3f {
    // a lobe of GGX in place of a Gaussian
    return engine_around(engine_frame * direction, sqrt(min(${ALPHA_OF_SPREAD} * spread, 1.0)));
}`;

/** A package that has the function is not valid without this one, although nothing calls it under other lights. */
const NO_HOST = "fn environment_radiance(direction: vec3f, spread: f32) -> vec3f { return vec3f(0.0); }";

/** Surroundings of a probe. */
const SKY = `fn environment_radiance(direction: vec3f, spread: f32) -> vec3f {
    var sum = engine_sky[0].rgb;
    let blur = engine_sky[0].w * spread * engine_sky[0].w * spread;
    for (var i = 1; i < ${1 + 2 * SKY_LOBES}; i += 2) {
        let axis = engine_sky[i];
        let own = axis.w * axis.w;
        sum += own / (own + blur) * exp((dot(direction, axis.xyz) - 1.0) / (own + blur)) * engine_sky[i + 1].rgb;
    }
    return sum;
}`;
const SKY_STATE = `var<private> engine_sky: array<vec4f, ${1 + 2 * SKY_LOBES}>;
`;

/** What is shown of a radiance: hues are kept, the greatest channel tends to 1. */
const SHOWN = `fn engine_shown(radiance: vec3f, exposure: f32) -> vec3f {
    var linear = exposure * max(radiance, vec3f(0.0));
    linear /= 1.0 + max(linear.r, max(linear.g, linear.b));
    let low = 12.92 * linear;
    let high = 1.055 * pow(linear, vec3f(1.0 / 2.4)) - 0.055;
    return select(high, low, linear <= vec3f(0.0031308));
}`;

const BEHIND = `fn behind(to: vec3f, turn: vec3f, exposure: f32, last_level: f32, surroundings: texture_cube<f32>) -> vec4f {
    engine_turn = turn;
    engine_last_level = last_level;
    return vec4f(engine_shown(engine_around(normalize(to), ${ROUGHNESS_BEHIND}), exposure), 1.0);
}`;

/** Widens what is called by the footprint of the pixel. */
const WIDENED = `
    let n_here = normalize(normal);
    let t_here = normalize(tangent.xyz - n_here * dot(n_here, tangent.xyz));
    let own = mat3x3f(t_here, cross(n_here, t_here) * tangent.w, n_here);
    let cosine = select((light * own).z, light.z, is_map > 0.5);
    let viewer = select((normalize(eye - place) * own).xy, place.xy, is_map > 0.5);
    let path = select((light * own).xy, light.xy, is_map > 0.5) + viewer;${widened(["vec2f", (name) => `let ${name}`], "dpdx", "dpdy")}`;

// world space is the bodies' own; the same in GLSL is in webgl2.js
const shade = (calls) => (parameters, tables) => `fn shade(place: vec3f, normal: vec3f, tangent: vec4f, body: vec3f, eye: vec3f, light: vec3f, light_a: vec3f, light_b: vec3f, light_c: vec3f, light_d: vec3f, radius: f32, reach: f32, scale: f32, turn: vec3f, exposure: f32, is_map: f32, samples: f32${calls === AROUND ? ", last_level: f32, surroundings: texture_cube<f32>" : ""}${parameters}) -> vec4f {${calls === AROUND ? `
    engine_turn = turn;
    engine_last_level = last_level;` : ""}
${calls === SPREAD ? WIDENED : "\n    let lobe_size = radius;"}
    // a lobe may be much narrower than what a pixel sees: places over the pixel, by the plastic number
    let place_x = dpdx(place);
    let place_y = dpdy(place);
    let normal_x = dpdx(normal);
    let normal_y = dpdy(normal);
    let tangent_x = dpdx(tangent.xyz);
    let tangent_y = dpdy(tangent.xyz);
    // radiance and cover
    var sum = vec4f(0.0);
    for (var i = 0.0; i < samples; i += 1.0) {
        let at = fract(0.5 + i * vec2f(0.7548777, 0.5698403)) - 0.5;
        let here = place + at.x * place_x + at.y * place_y;
        var frame = mat3x3f(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        var wr = here;
        if (is_map > 0.5) {
            let inside = 1.0 - dot(here.xy, here.xy);
            if (inside <= 0.0) {
                continue;
            }
            wr.z = sqrt(inside);
        } else {
            let n = normalize(normal + at.x * normal_x + at.y * normal_y);
            let along = tangent.xyz + at.x * tangent_x + at.y * tangent_y;
            let t = normalize(along - n * dot(n, along));
            frame = mat3x3f(t, cross(n, t) * tangent.w, n);
            wr = normalize(eye - here) * frame;
        }
        sum.a += 1.0;
        // a vector times the frame is that vector in the frame${calls === AROUND ? `
        // at the rim normals turn away: black would show before what is bright
        wr = normalize(vec3f(wr.xy, max(wr.z, 0.01)));
        engine_frame = frame;
        sum += vec4f(${calls}(${CALLS[calls]}${tables(calls)}), 0.0);
        if (is_map < 0.5) {
            let mirrored = 0.04 + 0.96 * pow(1.0 - wr.z, 5.0);
            // the roughest level is what a diffuser sees
            sum += vec4f((1.0 - mirrored) * engine_around(frame[2], 1.0) * body, 0.0);
        }` : `
        let wi = light * frame;
        if (wi.z <= -reach || wr.z <= 0.0) {
            continue;
        }
        let a = light_a * frame;
        let b = light_b * frame;
        let c = light_c * frame;
        let d = light_d * frame;
        sum += vec4f(scale * ${calls}(${CALLS[calls].replace("radius", "lobe_size")}${tables(calls)}), 0.0);
        if (is_map < 0.5) {
            let cos_half = dot(normalize(wi + wr), wr);
            let reflected = 0.04 + 0.96 * pow(1.0 - cos_half, 5.0);
            // of a light that sets, nearly
            var lit = wi.z;
            if (wi.z < reach) {
                lit = (wi.z + reach) * (wi.z + reach) / (4.0 * reach);
            }
            sum += vec4f((1.0 - reflected) * lit * body, 0.0);
        }`}
    }
    if (sum.a == 0.0) { return vec4f(0.0); }
    let cover = sum.a / samples;
    return vec4f(cover * engine_shown(sum.rgb / sum.a, exposure), cover);
}`;

const probeText = (functions, isStudio) => (parameters, tables) => `fn engine_probe(place: vec2f, engine_arguments: texture_2d<f32>${isStudio ? ", last_level: f32, surroundings: texture_cube<f32>" : ""}${parameters}) -> vec4f {
    let column = i32(place.x);${isStudio ? `
    engine_turn = vec3f(1.0, 0.0, 0.0);
    engine_last_level = last_level;
    engine_frame = mat3x3f(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0);` : `
    for (var i = 0; i < ${1 + 2 * SKY_LOBES}; i++) {
        engine_sky[i] = textureLoad(engine_arguments, vec2i(column, ${SKY_ROW} + i), 0);
    }`}
    let first = textureLoad(engine_arguments, vec2i(column, 0), 0);
    let viewer = textureLoad(engine_arguments, vec2i(column, 1), 0);
    let a = first.xyz;
    let second = textureLoad(engine_arguments, vec2i(column, 2), 0);
    let third = textureLoad(engine_arguments, vec2i(column, 3), 0);
    let fourth = textureLoad(engine_arguments, vec2i(column, 4), 0);
    let b = second.xyz;
    let c = third.xyz;
    let d = fourth.xyz;
    let tint = vec3f(second.w, third.w, fourth.w);
    let radius = viewer.w;
    let wr = viewer.xyz;
    let is_xyz = place.y < 1.0;
    let which = i32(first.w);${functions.map((name) => `
    if (which == ${Object.keys(CALLS).indexOf(name)}) {
        if (is_xyz) { return vec4f(${tristimulus(name)}(${CALLS[name]}${tables(name)}), 1.0); }
        return vec4f(${name}(${CALLS[name]}${tables(name)}), 1.0);
    }`).join("")}
    return vec4f(0.0);
}`;

/** What a driver may take to answer, milliseconds. */
const PATIENCE_MS = 20000;

/** The engine on a canvas; `onLost` gets words when the driver gives up. */
export async function open(canvas, onLost) {
  if (!navigator.gpu) throw new Error(window.isSecureContext ? "this browser has no WebGPU" : "browsers have WebGPU on secure addresses only");
  const adapter = await soon(navigator.gpu.requestAdapter());
  if (!adapter) throw new Error("the browser finds no driver for WebGPU");
  const renderer = new WebGPURenderer({ canvas, antialias: true, alpha: true });
  // the shader itself encodes
  renderer.outputColorSpace = LinearSRGBColorSpace;
  renderer.toneMapping = NoToneMapping;
  await soon(renderer.init());
  if (!renderer.backend.isWebGPUBackend) throw new Error("three.js fell back to WebGL2");
  const { device } = renderer.backend;
  let isLost = false;
  const lost = device.lost.then(() => {
    isLost = true;
  });
  renderer.onDeviceLost = ({ reason, message }) => {
    if (reason !== "destroyed") onLost(`The device of WebGPU was lost: ${message.replace(/\.$/, "")}`);
  };
  let studio;
  const made = () => (studio ??= prefiltered(new PMREMGenerator(renderer)));
  const { vendor, architecture, description } = adapter.info;
  return {
    renderer,
    driver: [vendor, architecture, description].filter(Boolean).join(" "),
    material: (variant, calls) => bodyMaterial(variant, calls, calls === AROUND ? made() : null),
    draw: async (scene, camera) => {
      if (isLost) return;
      renderer.render(scene, camera);
      await Promise.race([device.queue.onSubmittedWorkDone(), lost]);
    },
    probe: (variant, probes, isStudio) => probe(renderer, variant, probes, isStudio ? made() : null),
    dispose: () => renderer.dispose(),
  };
}

/** What a promise brings, or an error where it brings nothing for long. */
function soon(promise) {
  const late = new Promise((_, failed) => {
    setTimeout(() => failed(new Error(`WebGPU has not answered in ${PATIENCE_MS / 1000} s`)), PATIENCE_MS);
  });
  return Promise.race([promise, late]);
}

/**
 * A shell's node around functions of a variant: `make(parameters, tables)` is its text, given the declarations of all tables that they
 * read, and the names of those that one of them reads. `host` is what all of them need besides.
 */
function shell(variant, functions, bound, make, inputs, host) {
  const read = (name) => {
    const declared = variant.signature(name).match(/wr: vec3f(?:, spread: f32)?((?:, [^)]*)?)\)/)[1];
    return [...declared.matchAll(/, (\w+): (\w+)[^,]*/g)].map(([text, table, type]) => ({ text, table, type }));
  };
  const all = new Map(functions.flatMap(read).map((parameter) => [parameter.table, parameter]));
  const filtered = variant.tables.find((table) => table.isFiltered)?.name;
  const parameters = [...all.values()].map(({ text }) => text).join("");
  const text = make(parameters, (name) => read(name).map(({ table }) => `, ${table}`).join(""));
  // a sampler is that of the table which it reads
  const node = ({ table, type }) => (type === "sampler" ? sampler(texture(bound[filtered])) : texture(bound[table]));
  const nodes = Object.fromEntries([...all.values()].map((parameter) => [parameter.table, node(parameter)]));
  return wgslFn(text, [...host, wgslFn(variant.text)])({ ...inputs, ...nodes });
}

function bodyMaterial(variant, calls, studio) {
  const bound = textures(variant.tables);
  const knobs = {
    eye: uniform(new Vector3()),
    ...lightUniforms(uniform),
    exposure: uniform(1),
    is_map: uniform(0),
    samples: uniform(1),
  };
  const inputs = {
    place: varying(attribute("position", "vec3")),
    normal: varying(attribute("normal", "vec3")),
    tangent: varying(attribute("tangent", "vec4")),
    body: varying(attribute("body", "vec3")),
    ...knobs,
  };
  const material = new NodeMaterial();
  material.blending = NoBlending;
  const host = calls === AROUND ? [...aroundText(), wgslFn(HOST)] : variant.signature(AROUND) ? [wgslFn(NO_HOST)] : [];
  let behind = null;
  if (studio) {
    Object.assign(inputs, studioInputs(studio));
    behind = new NodeMaterial();
    behind.blending = NoBlending;
    const { turn, exposure } = knobs;
    const seen = { to: varying(positionGeometry), turn, exposure, ...studioInputs(studio) };
    behind.fragmentNode = wgslFn(BEHIND, [...aroundText(), wgslFn(SHOWN)])(seen);
  }
  material.fragmentNode = shell(variant, [calls], bound, shade(calls), inputs, [...host, wgslFn(SHOWN)]);
  const set = (values) => {
    for (const [name, value] of Object.entries(values)) {
      if (value.isVector3) knobs[name].value.copy(value);
      else knobs[name].value = Number(value);
    }
  };
  return {
    material, behind, set,
    dispose() {
      dispose(material, bound);
      behind?.dispose();
    },
  };
}

function aroundText() {
  return [wgsl(AROUND_STATE), wgslFn(AROUND_TEXT)];
}

function studioInputs({ texture, lastLevel }) {
  return { surroundings: cubeTexture(texture).setName("engine_surroundings"), last_level: uniform(lastLevel) };
}

/** A row of XYZ and one of RGB for probes. */
async function probe(renderer, variant, probes, studio) {
  const bound = { ...textures(variant.tables), engine_arguments: probeArguments(probes) };
  const material = new NodeMaterial();
  material.blending = NoBlending;
  const inputs = { place: screenCoordinate.xy, engine_arguments: texture(bound.engine_arguments) };
  const functions = functionsOf(variant);
  if (studio) Object.assign(inputs, studioInputs(studio));
  const sky = () => [wgsl(SKY_STATE), ...(functions.includes(AROUND) ? [wgslFn(SKY)] : [])];
  const host = studio ? [...aroundText(), wgslFn(HOST)] : sky();
  material.fragmentNode = shell(variant, functions, bound, probeText(functions, studio !== null), inputs, host);
  const options = { type: FloatType, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false };
  const picture = new RenderTarget(probes.length, 2, options);
  renderer.setRenderTarget(picture);
  new QuadMesh(material).render(renderer);
  renderer.setRenderTarget(null);
  const pixels = await renderer.readRenderTargetPixelsAsync(picture, 0, 0, probes.length, 2);
  picture.dispose();
  dispose(material, bound);
  return pixels;
}

function dispose(material, bound) {
  material.dispose();
  for (const table of Object.values(bound)) table.dispose();
}
