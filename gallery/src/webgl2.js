// The function form of GLSL ES 3.00 behind three.js's WebGLRenderer.
import {
  BufferAttribute, BufferGeometry, FloatType, GLSL3, Mesh, NearestFilter, NoBlending, OrthographicCamera, PMREMGenerator,
  RawShaderMaterial, Scene, Vector3, WebGLRenderer, WebGLRenderTarget,
} from "three";
import { AROUND, CALLS, functionsOf, lightUniforms, SPREAD, tristimulus, widened } from "./lights.js";
import { ALPHA_OF_SPREAD, prefiltered, ROUGHNESS_BEHIND } from "./surroundings.js";
import { probeArguments, SKY_LOBES, SKY_ROW, textures } from "./tables.js";

export const target = "glsl-es300";

const HEAD = "precision highp float;\nprecision highp int;\nprecision highp sampler2D;\nprecision highp sampler2DArray;\nprecision highp samplerCube;\n";

const VERTEX = `${HEAD}
in vec3 position;
in vec3 normal;
in vec4 tangent;
in vec3 body;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
out vec3 v_place;
out vec3 v_normal;
out vec4 v_tangent;
out vec3 v_body;
void main() {
    v_place = position;
    v_normal = normal;
    v_tangent = tangent;
    v_body = body;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

/** Radiance of three.js's prefiltered cube. */
const CUBE = `
uniform samplerCube surroundings;
uniform float last_level;
uniform vec3 turn;
// from a direction of the world, blurred as by that roughness
vec3 around(vec3 to, float roughness) {
    vec3 turned = vec3(turn.x * to.x + turn.y * to.z, to.y, turn.x * to.z - turn.y * to.x);
    return textureLod(surroundings, turned, last_level * roughness * (2.0 - roughness)).rgb;
}`;

/** What `diffraction_environment` asks for. The frame is that of the place, tangent to world. */
const HOST = `${CUBE}
mat3 engine_frame = mat3(1.0);
vec3 environment_radiance(vec3 direction, float spread) {
    // a lobe of GGX in place of a Gaussian
    float roughness = sqrt(min(${ALPHA_OF_SPREAD} * spread, 1.0));
    return around(engine_frame * direction, roughness);
}`;

/** A package that has the function cannot be linked without this one, although nothing calls it under other lights. */
const NO_HOST = "vec3 environment_radiance(vec3 direction, float spread) { return vec3(0.0); }";

/** Surroundings of a probe. */
const SKY = `
vec3 environment_radiance(vec3 direction, float spread) {
    vec4 constant = argument(${SKY_ROW});
    vec3 sum = constant.rgb;
    float blur = constant.w * spread * constant.w * spread;
    for (int i = 0; i < ${SKY_LOBES}; i++) {
        vec4 axis = argument(${SKY_ROW + 1} + 2 * i);
        float own = axis.w * axis.w;
        float share = own / (own + blur) * exp((dot(direction, axis.xyz) - 1.0) / (own + blur));
        sum += share * argument(${SKY_ROW + 2} + 2 * i).rgb;
    }
    return sum;
}`;

/** What is shown of a radiance: hues are kept, the greatest channel tends to 1. */
const SHOWN = `
uniform float exposure;
layout(location = 0) out vec4 colour;
vec3 shown(vec3 radiance) {
    vec3 linear = exposure * max(radiance, vec3(0.0));
    linear /= 1.0 + max(linear.r, max(linear.g, linear.b));
    vec3 low = 12.92 * linear;
    vec3 high = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
    return mix(high, low, lessThanEqual(linear, vec3(0.0031308)));
}`;

/** Widens what is called by the footprint of the pixel. */
const WIDENED = `void widen() {
    vec3 n = normalize(v_normal);
    vec3 t = normalize(v_tangent.xyz - n * dot(n, v_tangent.xyz));
    mat3 frame = is_map ? mat3(1.0) : mat3(t, cross(n, t) * v_tangent.w, n);
    float cosine = (light * frame).z;
    vec2 viewer = is_map ? v_place.xy : (normalize(eye - v_place) * frame).xy;
    vec2 path = (light * frame).xy + viewer;${widened(["vec2", (name, type = "float") => `${type} ${name}`], "dFdx", "dFdy")}
    wide_radius = lobe_size;
}`;

// world space is the bodies' own; the same in WGSL is in webgpu.js
const fragment = (variant, calls) => `
${calls === AROUND ? HOST : variant.signature(AROUND) ? NO_HOST : ""}
${SHOWN}
in vec3 v_place;
in vec3 v_normal;
in vec4 v_tangent;
in vec3 v_body;
uniform vec3 eye;
uniform vec3 light;
uniform vec3 light_a;
uniform vec3 light_b;
uniform vec3 light_c;
uniform vec3 light_d;
uniform float radius;
uniform float reach;
uniform float scale;
uniform bool is_map;
uniform int samples;

// of a disc, or the spread of lobes
float wide_radius;

// radiance by diffraction; a vector times the frame is that vector in the frame
vec3 diffracted(mat3 frame, vec3 wr) {${calls === AROUND ? "\n    engine_frame = frame;" : ""}
    vec3 a = light_a * frame, b = light_b * frame, c = light_c * frame, d = light_d * frame;
    return scale * ${calls}(${CALLS[calls].replace("radius", "wide_radius")});
}

// radiance and cover of a place
vec4 seen(vec3 place, vec3 normal, vec3 tangent) {
    if (is_map) {
        float inside = 1.0 - dot(place.xy, place.xy);
        return inside > 0.0 ? vec4(diffracted(mat3(1.0), vec3(place.xy, sqrt(inside))), 1.0) : vec4(0.0);
    }
    vec3 n = normalize(normal);
    vec3 t = normalize(tangent - n * dot(n, tangent));
    vec3 b = cross(n, t) * v_tangent.w;
    vec3 to_eye = normalize(eye - place);
    mat3 frame = mat3(t, b, n);
    vec3 wr = to_eye * frame;${calls === AROUND ? `
    // at the rim normals turn away: black would show before what is bright
    wr = normalize(vec3(wr.xy, max(wr.z, 0.01)));
    float mirrored = 0.04 + 0.96 * pow(1.0 - wr.z, 5.0);
    // the roughest level is what a diffuser sees
    return vec4(diffracted(frame, wr) + (1.0 - mirrored) * around(n, 1.0) * v_body, 1.0);
}` : `
    vec3 wi = light * frame;
    if (wi.z <= -reach || wr.z <= 0.0) { return vec4(0.0, 0.0, 0.0, 1.0); }
    float cos_half = dot(normalize(wi + wr), wr);
    float reflected = 0.04 + 0.96 * pow(1.0 - cos_half, 5.0);
    // of a light that sets, nearly
    float lit = wi.z >= reach ? wi.z : (wi.z + reach) * (wi.z + reach) / (4.0 * reach);
    return vec4(diffracted(frame, wr) + (1.0 - reflected) * lit * v_body, 1.0);
}`}

${calls === SPREAD ? WIDENED : "void widen() { wide_radius = radius; }"}

void main() {
    widen();
    // a lobe may be much narrower than what a pixel sees: places over the pixel, by the plastic number
    vec3 place_x = dFdx(v_place), place_y = dFdy(v_place);
    vec3 normal_x = dFdx(v_normal), normal_y = dFdy(v_normal);
    vec3 tangent_x = dFdx(v_tangent.xyz), tangent_y = dFdy(v_tangent.xyz);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < samples; i++) {
        vec2 at = fract(0.5 + float(i) * vec2(0.7548777, 0.5698403)) - 0.5;
        sum += seen(
            v_place + at.x * place_x + at.y * place_y,
            v_normal + at.x * normal_x + at.y * normal_y,
            v_tangent.xyz + at.x * tangent_x + at.y * tangent_y
        );
    }
    if (sum.a == 0.0) { discard; }
    float cover = sum.a / float(samples);
    colour = vec4(cover * shown(sum.rgb / sum.a), cover);
}`;

const BEHIND_VERTEX = `${HEAD}
in vec3 position;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
out vec3 v_to;
void main() {
    v_to = position;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const BEHIND = `${CUBE}${SHOWN}
in vec3 v_to;
void main() { colour = vec4(shown(around(normalize(v_to), ${ROUGHNESS_BEHIND})), 1.0); }`;

const probeText = (functions, isStudio) => `
uniform sampler2D engine_arguments;
layout(location = 0) out vec4 colour;
vec4 argument(int row) { return texelFetch(engine_arguments, ivec2(int(gl_FragCoord.x), row), 0); }
${isStudio ? HOST : SKY}
void main() {${isStudio ? "\n    engine_frame = mat3(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0);" : ""}
    int which = int(argument(0).w);
    bool is_xyz = gl_FragCoord.y < 1.0;
    vec3 a = argument(0).xyz, b = argument(2).xyz, c = argument(3).xyz, d = argument(4).xyz, wr = argument(1).xyz;
    float radius = argument(1).w;
    vec3 tint = vec3(argument(2).w, argument(3).w, argument(4).w);
    colour = vec4(0.0);${functions.map((name) => `
    if (which == ${Object.keys(CALLS).indexOf(name)}) {
        colour = vec4(is_xyz ? ${tristimulus(name)}(${CALLS[name]}) : ${name}(${CALLS[name]}), 1.0);
    }`).join("")}
}`;

const CORNERS = "in vec3 position;\nvoid main() { gl_Position = vec4(position, 1.0); }";

/** The engine on a canvas; `onLost` gets words when the driver gives up. */
export async function open(canvas, onLost) {
  const renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
  const gl = renderer.getContext();
  canvas.addEventListener("webglcontextlost", () => onLost("The context of WebGL2 was lost"));
  const unmasked = gl.getExtension("WEBGL_debug_renderer_info");
  let studio;
  const made = () => (studio ??= prefiltered(new PMREMGenerator(renderer)));
  return {
    renderer,
    driver: gl.getParameter(unmasked?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER),
    /** A material for bodies that calls a function of the variant, with one for what is `behind`, `set(uniforms)` and `dispose()`. */
    material: (variant, calls) => bodyMaterial(variant, calls, calls === AROUND ? made() : null),
    /** Draws, and returns when the picture is done. */
    draw: async (scene, camera) => {
      renderer.render(scene, camera);
      await done(gl);
    },
    /** XYZ and RGB of probes, under their skies or, all of them, in the studio: with the normal up and the tangent along x. */
    probe: (variant, probes, isStudio) => probe(renderer, variant, probes, isStudio ? made() : null),
    dispose: () => renderer.dispose(),
  };
}

/** Resolves when the driver is done; `finish` does not wait in browsers, and reading a pixel stalls with a warning. */
async function done(gl) {
  const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  gl.flush();
  while (!gl.isContextLost() && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) {
    await new Promise((next) => setTimeout(next, 2));
  }
  gl.deleteSync(fence);
}

function bodyMaterial(variant, calls, studio) {
  const bound = textures(variant.tables);
  const uniforms = {
    eye: { value: new Vector3() },
    ...lightUniforms((value) => ({ value })),
    exposure: { value: 1 },
    is_map: { value: false },
    samples: { value: 1 },
    ...(studio && studioUniforms(studio)),
  };
  const material = raw(VERTEX, variant.text + fragment(variant, calls), bound, uniforms);
  const behind = calls === AROUND ? raw(BEHIND_VERTEX, BEHIND, {}, uniforms) : null;
  const set = (values) => {
    for (const [name, value] of Object.entries(values)) {
      if (value.isVector3) uniforms[name].value.copy(value);
      else uniforms[name].value = value;
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

function studioUniforms({ texture, lastLevel }) {
  return { surroundings: { value: texture }, last_level: { value: lastLevel } };
}

/** A row of XYZ and one of RGB for probes. */
async function probe(renderer, variant, probes, studio) {
  if (!renderer.extensions.has("EXT_color_buffer_float")) throw new Error("no 32-bit float targets");
  const bound = { ...textures(variant.tables), engine_arguments: probeArguments(probes) };
  const uniforms = studio ? { ...studioUniforms(studio), turn: { value: new Vector3(1, 0, 0) } } : {};
  const material = raw(CORNERS, variant.text + probeText(functionsOf(variant), studio !== null), bound, uniforms);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  const scene = new Scene();
  scene.add(mesh);
  const options = { type: FloatType, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false };
  const picture = new WebGLRenderTarget(probes.length, 2, options);
  renderer.setRenderTarget(picture);
  renderer.render(scene, new OrthographicCamera());
  renderer.setRenderTarget(null);
  const pixels = new Float32Array(probes.length * 8);
  renderer.readRenderTargetPixels(picture, 0, 0, probes.length, 2, pixels);
  picture.dispose();
  geometry.dispose();
  dispose(material, bound);
  return pixels;
}

function raw(vertex, fragment, bound, uniforms) {
  const values = Object.entries(bound).map(([name, value]) => [name, { value }]);
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: vertex,
    fragmentShader: HEAD + fragment,
    uniforms: { ...Object.fromEntries(values), ...uniforms },
    blending: NoBlending,
  });
}

function dispose(material, bound) {
  material.dispose();
  for (const texture of Object.values(bound)) texture.dispose();
}
