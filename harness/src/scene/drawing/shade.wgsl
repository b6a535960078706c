// The harness's shading of a body. It is appended to the shader of a variant, whose functions it calls.

struct Shade {
    // x: weight w_d of the unlit texture; y: diffuser scale s; z: number of lights; w: level of this pass
    blend: vec4f,
    // x: last level, or below 0 if lobes are not widened; y: (λ σf)² of level 0; zw: unused
    widening: vec4f,
    // xyz: direction to the light
    directions: array<vec4f, 4>,
    // rgb: radiance of a white diffuser that faces the light
    colours: array<vec4f, 4>,
}
@group(0) @binding(20) var<uniform> shade: Shade;
@group(0) @binding(21) var body_colour: texture_2d<f32>;
@group(0) @binding(22) var body_sampler: sampler;

// The colour of a body: its lit colour, plus the diffraction.
@fragment
fn scene_skin(
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
) -> @location(0) vec4f {
    let colour = body(place, normal, tangent, uv);
    return vec4f(held(colour + glints(place, normal, tangent, uv)), 1.0);
}

// The contribution of a further level of widened lobes, to be added.
@fragment
fn scene_level(
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
) -> @location(0) vec4f {
    return vec4f(held(glints(place, normal, tangent, uv)), 0.0);
}

// (1 - w_d) (1 - R) c n·l + w_d c, summed over the lights; R is the Fresnel reflectance at the half vector.
fn body(place: vec3f, normal: vec3f, tangent: vec4f, uv: vec2f) -> vec3f {
    let texture = textureSample(body_colour, body_sampler, uv).rgb;
    let wr = in_frame(mesh_params.eye.xyz - place, normal, tangent, uv);
    let amplitude = (REFRACTIVE_INDEX - 1.0) / (REFRACTIVE_INDEX + 1.0);
    var lit = vec3f(0.0);
    for (var i = 0; i < i32(shade.blend.z); i++) {
        let wi = in_frame(shade.directions[i].xyz, normal, tangent, uv);
        if (wi.z > 0.0 && wr.z > 0.0) {
            let reflectance = amplitude * amplitude * fresnel_ratio(dot(normalize(wi + wr), wr));
            lit += (1.0 - reflectance) * wi.z * shade.colours[i].rgb;
        }
    }
    return ((1.0 - shade.blend.x) * lit + shade.blend.x) * texture;
}

// (1 - w_d) s ρ, summed over the lights; if lobes are widened, the share of this pass's level.
fn glints(place: vec3f, normal: vec3f, tangent: vec4f, uv: vec2f) -> vec3f {
    let wr = in_frame(mesh_params.eye.xyz - place, normal, tangent, uv);
    var sum = vec3f(0.0);
    for (var i = 0; i < i32(shade.blend.z); i++) {
        let wi = in_frame(shade.directions[i].xyz, normal, tangent, uv);
        let share = level_share(wi.xy + wr.xy);
        if (wi.z > 0.0 && wr.z > 0.0 && share > 0.0) {
            sum += share * shade.colours[i].rgb * diffraction(wi, wr);
        }
    }
    return (1.0 - shade.blend.x) * shade.blend.y * sum;
}

// Clamps to the range of 16-bit floats.
fn held(radiance: vec3f) -> vec3f {
    return clamp(radiance, vec3f(-6e4), vec3f(6e4));
}

// The directions inside a pixel have a variance of (u, v) of a twelfth of the squared steps between pixels. This widens the
// lobe to σf² + σpix². Level k has a lobe 2^k times as wide.
fn level_share(path: vec2f) -> f32 {
    let right = dpdx(path);
    let down = dpdy(path);
    if (shade.widening.x < 0.0) {
        return 1.0;
    }
    let pixel = (dot(right, right) + dot(down, down)) / 12.0;
    let level = 0.5 * log2(1.0 + pixel / shade.widening.y);
    return max(0.0, 1.0 - abs(min(level, shade.widening.x) - shade.blend.w));
}

struct Used {
    // xyz: direction to the light; w: distance from the viewer
    @location(0) wi: vec4f,
    // xyz: direction to the viewer; w: 1
    @location(1) wr: vec4f,
}

// The directions that the entry point `mesh` uses.
@fragment
fn scene_directions(
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
) -> Used {
    let wi = in_frame(mesh_params.light_direction.xyz, normal, tangent, uv);
    let wr = in_frame(mesh_params.eye.xyz - place, normal, tangent, uv);
    return Used(vec4f(wi, distance(mesh_params.eye.xyz, place)), vec4f(wr, 1.0));
}
