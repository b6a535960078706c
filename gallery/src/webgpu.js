// The function form of WGSL behind three.js's WebGPURenderer, as a node of its shading language.
import { FloatType, LinearSRGBColorSpace, NearestFilter, NoBlending, NoToneMapping, RenderTarget, Vector3 } from "three";
import { attribute, sampler, screenCoordinate, texture, uniform, varying, wgslFn } from "three/tsl";
import { NodeMaterial, QuadMesh, WebGPURenderer } from "three/webgpu";
import { directions, textures } from "./tables.js";

export const target = "wgsl";

// world space is the bodies' own; the same in GLSL is in webgl2.js
const shade = (parameters, tables) => `fn shade(place: vec3f, normal: vec3f, tangent: vec4f, body: vec3f, eye: vec3f, light: vec3f, diffuser: f32, exposure: f32, is_map: f32, samples: f32${parameters}) -> vec4f {
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
        if (is_map > 0.5) {
            let inside = 1.0 - dot(here.xy, here.xy);
            if (inside > 0.0) {
                sum += vec4f(diffuser * diffraction(light, vec3f(here.xy, sqrt(inside))${tables}), 1.0);
            }
            continue;
        }
        let n = normalize(normal + at.x * normal_x + at.y * normal_y);
        let along = tangent.xyz + at.x * tangent_x + at.y * tangent_y;
        let t = normalize(along - n * dot(n, along));
        let b = cross(n, t) * tangent.w;
        let to_eye = normalize(eye - here);
        let wi = vec3f(dot(light, t), dot(light, b), dot(light, n));
        let wr = vec3f(dot(to_eye, t), dot(to_eye, b), dot(to_eye, n));
        sum.a += 1.0;
        if (wi.z > 0.0 && wr.z > 0.0) {
            let cos_half = dot(normalize(wi + wr), wr);
            let reflected = 0.04 + 0.96 * pow(1.0 - cos_half, 5.0);
            sum += vec4f(diffuser * diffraction(wi, wr${tables}) + (1.0 - reflected) * wi.z * body, 0.0);
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

const probeText = (parameters, tables) => `fn engine_probe(place: vec2f, engine_directions: texture_2d<f32>${parameters}) -> vec4f {
    let at = vec2i(place);
    let wi = textureLoad(engine_directions, vec2i(at.x, 0), 0).xyz;
    let wr = textureLoad(engine_directions, vec2i(at.x, 1), 0).xyz;
    if (at.y == 0) { return vec4f(tristimulus(wi, wr${tables}), 1.0); }
    return vec4f(diffraction(wi, wr${tables}), 1.0);
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
    material: (variant) => bodyMaterial(variant),
    draw: async (scene, camera) => {
      if (isLost) return;
      renderer.render(scene, camera);
      await Promise.race([device.queue.onSubmittedWorkDone(), lost]);
    },
    probe: (variant, pairs) => probe(renderer, variant, pairs),
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

/** A shell's node around a variant: `make(parameters, tables)` is its text, given the tables' declarations and names. */
function shell(variant, bound, make, inputs) {
  const declared = variant.signature("diffraction").match(/wr: vec3f((?:, [^)]*)?)\)/)[1];
  const parameters = [...declared.matchAll(/, (\w+): (\w+)/g)].map(([, name, type]) => ({ name, type }));
  const names = parameters.map(({ name }) => name);
  const filtered = variant.tables.find((table) => table.isFiltered)?.name;
  const text = make(declared, names.map((name) => `, ${name}`).join(""));
  // a sampler is that of the table which it reads
  const node = ({ name, type }) => (type === "sampler" ? sampler(texture(bound[filtered])) : texture(bound[name]));
  const nodes = Object.fromEntries(parameters.map((parameter) => [parameter.name, node(parameter)]));
  return wgslFn(text, [wgslFn(variant.text)])({ ...inputs, ...nodes });
}

function bodyMaterial(variant) {
  const bound = textures(variant.tables);
  const knobs = {
    eye: uniform(new Vector3()),
    light: uniform(new Vector3(0, 0, 1)),
    diffuser: uniform(1),
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
  material.fragmentNode = shell(variant, bound, shade, inputs);
  const set = (values) => {
    for (const [name, value] of Object.entries(values)) {
      if (value.isVector3) knobs[name].value.copy(value);
      else knobs[name].value = Number(value);
    }
  };
  return { material, set, dispose: () => dispose(material, bound) };
}

/** XYZ and RGB for each pair of directions. */
async function probe(renderer, variant, pairs) {
  const bound = { ...textures(variant.tables), engine_directions: directions(pairs) };
  const material = new NodeMaterial();
  material.blending = NoBlending;
  const inputs = { place: screenCoordinate.xy, engine_directions: texture(bound.engine_directions) };
  material.fragmentNode = shell(variant, bound, probeText, inputs);
  const options = { type: FloatType, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false };
  const picture = new RenderTarget(pairs.length, 2, options);
  renderer.setRenderTarget(picture);
  new QuadMesh(material).render(renderer);
  renderer.setRenderTarget(null);
  const pixels = await renderer.readRenderTargetPixelsAsync(picture, 0, 0, pairs.length, 2);
  picture.dispose();
  dispose(material, bound);
  return pixels;
}

function dispose(material, bound) {
  material.dispose();
  for (const table of Object.values(bound)) table.dispose();
}
