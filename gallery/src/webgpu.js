// The function form of WGSL behind three.js's WebGPURenderer, as a node of its shading language.
import { FloatType, LinearSRGBColorSpace, NearestFilter, NoBlending, NoToneMapping, RenderTarget, Vector3 } from "three";
import { attribute, sampler, screenCoordinate, texture, uniform, varying, wgslFn } from "three/tsl";
import { NodeMaterial, QuadMesh, WebGPURenderer } from "three/webgpu";
import { CALLS, functionsOf, lightUniforms, tristimulus } from "./lights.js";
import { probeArguments, textures } from "./tables.js";

export const target = "wgsl";

// world space is the bodies' own; the same in GLSL is in webgl2.js
const shade = (calls) => (parameters, tables) => `fn shade(place: vec3f, normal: vec3f, tangent: vec4f, body: vec3f, eye: vec3f, light: vec3f, light_a: vec3f, light_b: vec3f, light_c: vec3f, light_d: vec3f, radius: f32, reach: f32, scale: f32, exposure: f32, is_map: f32, samples: f32${parameters}) -> vec4f {
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
        // a vector times the frame is that vector in the frame
        let wi = light * frame;
        if (wi.z <= -reach || wr.z <= 0.0) {
            continue;
        }
        let a = light_a * frame;
        let b = light_b * frame;
        let c = light_c * frame;
        let d = light_d * frame;
        sum += vec4f(scale * ${calls}(${CALLS[calls]}${tables(calls)}), 0.0);
        if (is_map < 0.5) {
            let cos_half = dot(normalize(wi + wr), wr);
            let reflected = 0.04 + 0.96 * pow(1.0 - cos_half, 5.0);
            // of a light that sets, nearly
            var lit = wi.z;
            if (wi.z < reach) {
                lit = (wi.z + reach) * (wi.z + reach) / (4.0 * reach);
            }
            sum += vec4f((1.0 - reflected) * lit * body, 0.0);
        }
    }
    if (sum.a == 0.0) { return vec4f(0.0); }
    // keeps hues: the greatest channel tends to 1
    var shown = exposure * max(sum.rgb, vec3f(0.0)) / sum.a;
    shown /= 1.0 + max(shown.r, max(shown.g, shown.b));
    let low = 12.92 * shown;
    let high = 1.055 * pow(shown, vec3f(1.0 / 2.4)) - 0.055;
    let cover = sum.a / samples;
    return vec4f(cover * select(high, low, shown <= vec3f(0.0031308)), cover);
}`;

const probeText = (functions) => (parameters, tables) => `fn engine_probe(place: vec2f, engine_arguments: texture_2d<f32>${parameters}) -> vec4f {
    let column = i32(place.x);
    let first = textureLoad(engine_arguments, vec2i(column, 0), 0);
    let viewer = textureLoad(engine_arguments, vec2i(column, 1), 0);
    let a = first.xyz;
    let b = textureLoad(engine_arguments, vec2i(column, 2), 0).xyz;
    let c = textureLoad(engine_arguments, vec2i(column, 3), 0).xyz;
    let d = textureLoad(engine_arguments, vec2i(column, 4), 0).xyz;
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
  const { vendor, architecture, description } = adapter.info;
  return {
    renderer,
    driver: [vendor, architecture, description].filter(Boolean).join(" "),
    material: (variant, calls) => bodyMaterial(variant, calls),
    draw: async (scene, camera) => {
      if (isLost) return;
      renderer.render(scene, camera);
      await Promise.race([device.queue.onSubmittedWorkDone(), lost]);
    },
    probe: (variant, probes) => probe(renderer, variant, probes),
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
 * read, and the names of those that one of them reads.
 */
function shell(variant, functions, bound, make, inputs) {
  const read = (name) => {
    const declared = variant.signature(name).match(/wr: vec3f((?:, [^)]*)?)\)/)[1];
    return [...declared.matchAll(/, (\w+): (\w+)[^,]*/g)].map(([text, table, type]) => ({ text, table, type }));
  };
  const all = new Map(functions.flatMap(read).map((parameter) => [parameter.table, parameter]));
  const filtered = variant.tables.find((table) => table.isFiltered)?.name;
  const parameters = [...all.values()].map(({ text }) => text).join("");
  const text = make(parameters, (name) => read(name).map(({ table }) => `, ${table}`).join(""));
  // a sampler is that of the table which it reads
  const node = ({ table, type }) => (type === "sampler" ? sampler(texture(bound[filtered])) : texture(bound[table]));
  const nodes = Object.fromEntries([...all.values()].map((parameter) => [parameter.table, node(parameter)]));
  return wgslFn(text, [wgslFn(variant.text)])({ ...inputs, ...nodes });
}

function bodyMaterial(variant, calls) {
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
  material.fragmentNode = shell(variant, [calls], bound, shade(calls), inputs);
  const set = (values) => {
    for (const [name, value] of Object.entries(values)) {
      if (value.isVector3) knobs[name].value.copy(value);
      else knobs[name].value = Number(value);
    }
  };
  return { material, set, dispose: () => dispose(material, bound) };
}

/** A row of XYZ and one of RGB for probes. */
async function probe(renderer, variant, probes) {
  const bound = { ...textures(variant.tables), engine_arguments: probeArguments(probes) };
  const material = new NodeMaterial();
  material.blending = NoBlending;
  const inputs = { place: screenCoordinate.xy, engine_arguments: texture(bound.engine_arguments) };
  const functions = functionsOf(variant);
  material.fragmentNode = shell(variant, functions, bound, probeText(functions), inputs);
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
