// The harness's shading of a body. It is appended to the shader of a variant, whose functions it calls. Functions that the
// variant does not have are appended, too: they return black.

struct Shade {
    // x: weight w_d of the unlit texture; y: diffuser scale s; z: radiance of an unlit white; w: 1 if light is diffracted, 0
    // for the body alone
    blend: vec4f,
    // x: number of single directions; y: of discs; z: of polygons; w: 1 under skies or maps
    counts: vec4f,
    // xyz: direction to the light; w: unused
    directions: array<vec4f, 4>,
    // xyz: to the middle of the disc; w: angular radius in radians
    discs: array<vec4f, 4>,
    // rgb: irradiance of four single directions, of four discs, radiance of four polygons; w: number of a polygon's corners
    powers: array<vec4f, 12>,
    // xyz: corner; eight for each polygon
    corners: array<vec4f, 32>,
}
@group(0) @binding(20) var<uniform> shade: Shade;
@group(0) @binding(21) var body_colour: texture_2d<f32>;
@group(0) @binding(22) var body_sampler: sampler;

struct Whites {
    // rgb: radiance of a white diffuser under skies and maps, by its normal: 45 rows of 90. Rows count theta from +y, the first and
    // the last at the poles; columns count phi from +x towards +z, the first at -180°
    texels: array<vec4f, 4050>,
}
@group(0) @binding(23) var<uniform> whites: Whites;

const FIRST_DISC: i32 = 4;
const FIRST_POLYGON: i32 = 8;
// roughness of the lobe for comparison, GGX's alpha
const GGX_ALPHA: f32 = 0.2;

// The colour of a body: its lit colour, plus the diffraction.
@fragment
fn scene_skin(
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
) -> @location(0) vec4f {
    // the frame has the angle of the map
    let ratios = pattern_ratios(uv);
    let pattern = vec4f(1.0, 0.0, ratios.xy);
    let colour = body(ratios.z, place, normal, tangent, uv);
    return vec4f(held(colour + ratios.z * glints(place, normal, tangent, uv)), 1.0);
}

// (1 - w_d) times the lit texture, and w_d times the unlit one. `covered`: share of the area below the relief.
fn body(covered: f32, place: vec3f, normal: vec3f, tangent: vec4f, uv: vec2f) -> vec3f {
    let texture = textureSample(body_colour, body_sampler, uv).rgb;
    let lit = diffuse(covered, place, normal, tangent, uv);
    return ((1.0 - shade.blend.x) * lit + shade.blend.x * shade.blend.z) * texture;
}

// Radiance of a white body: (1 - R) times irradiance over π, summed over the lights. R is the Fresnel reflectance at the half
// vector between the viewer and the middle of the light; for skies and maps, between the viewer and the normal.
fn diffuse(covered: f32, place: vec3f, normal: vec3f, tangent: vec4f, uv: vec2f) -> vec3f {
    let wr = in_frame(mesh_params.eye.xyz - place, normal, tangent, uv);
    if (!(wr.z > 0.0)) {
        return vec3f(0.0);
    }
    var irradiance = vec3f(0.0);
    for (var i = 0; i < i32(shade.counts.x); i++) {
        let wi = in_frame(shade.directions[i].xyz, normal, tangent, uv);
        irradiance += transmitted(covered, wi, wr) * max(wi.z, 0.0) * shade.powers[i].rgb;
    }
    for (var i = 0; i < i32(shade.counts.y); i++) {
        // a disc across the horizon counts whole or not at all
        let wi = in_frame(shade.discs[i].xyz, normal, tangent, uv);
        irradiance += transmitted(covered, wi, wr) * max(wi.z, 0.0) * shade.powers[FIRST_DISC + i].rgb;
    }
    for (var i = 0; i < i32(shade.counts.z); i++) {
        irradiance += polygon_share(covered, i, wr, normal, tangent, uv) * shade.powers[FIRST_POLYGON + i].rgb;
    }
    var white = irradiance / 3.1415927;
    if (shade.counts.w > 0.5) {
        white += transmitted(covered, vec3f(0.0, 0.0, 1.0), wr) * white_under_surroundings(unit(normal, 1e-8));
    }
    return white;
}

// Radiance of a white diffuser under skies and maps, by its normal in the world, bilinear.
fn white_under_surroundings(normal: vec3f) -> vec3f {
    let row = clamp(atan2(length(normal.xz), normal.y) / 3.1415927, 0.0, 1.0) * 44.0;
    let column = (atan2(normal.z, normal.x) / 3.1415927 + 1.0) * 45.0;
    let top = floor(row);
    let left = floor(column);
    let above = white_line(i32(top), i32(left), column - left);
    let below = white_line(min(i32(top) + 1, 44), i32(left), column - left);
    return mix(above, below, row - top);
}

fn white_line(row: i32, left: i32, share: f32) -> vec3f {
    let first = whites.texels[90 * row + left % 90].rgb;
    return mix(first, whites.texels[90 * row + (left + 1) % 90].rgb, share);
}

// 1 - R for light from a direction. Below a metal there is no body, and below other matter R is that of normal incidence.
fn transmitted(covered: f32, wi: vec3f, wr: vec3f) -> f32 {
    if (BODY_SHARE < 1.0) {
        return mix(1.0, BODY_SHARE, covered);
    }
    return 1.0 - covered * body_reflectance(dot(unit(wi + wr, 1e-8), wr));
}

// 1 - R times the integral of the cosine over the part of a polygon above the horizon: half the sum over its edges (Lambert
// 1760; Arvo 1995). Where the polygon is cut, the horizon is an edge.
fn polygon_share(covered: f32, index: i32, wr: vec3f, normal: vec3f, tangent: vec4f, uv: vec2f) -> f32 {
    let count = i32(shade.powers[FIRST_POLYGON + index].w);
    var start = corner(index, count - 1, normal, tangent, uv);
    var middle = vec3f(0.0);
    var sum = 0.0;
    var sets = vec3f(0.0);
    var rises = vec3f(0.0);
    for (var i = 0; i < count; i++) {
        let end = corner(index, i, normal, tangent, uv);
        middle += end;
        if (start.z > 0.0 || end.z > 0.0) {
            var from_point = start;
            var to_point = end;
            if (end.z <= 0.0) {
                to_point = normalize(mix(start, end, start.z / (start.z - end.z)));
                sets = to_point;
            }
            if (start.z <= 0.0) {
                from_point = normalize(mix(start, end, start.z / (start.z - end.z)));
                rises = from_point;
            }
            sum += edge_share(from_point, to_point);
        }
        start = end;
    }
    sum += edge_share(sets, rises);
    // a mirrored frame turns the corners round
    return 0.5 * abs(sum) * transmitted(covered, unit(middle, 1e-8), wr);
}

// The angle of an edge times the z of the normal of its plane. Short edges take a series, since the sum over the edges of a small
// polygon is much smaller than its terms.
fn edge_share(start: vec3f, end: vec3f) -> f32 {
    let across = cross(start, end);
    let squared = dot(across, across);
    let along = dot(start, end);
    if (squared < 0.09 && along >= 0.0) {
        return across.z * (1.0 + squared * (1.0 / 6.0 + squared * (0.075 + squared * (5.0 / 112.0))));
    }
    let sine = sqrt(squared);
    return across.z * atan2(sine, along) / max(sine, 1e-6);
}

// Corner of a polygon in the frame of a fragment.
fn corner(index: i32, number: i32, normal: vec3f, tangent: vec4f, uv: vec2f) -> vec3f {
    return in_frame(shade.corners[8 * index + number].xyz, normal, tangent, uv);
}

// (1 - w_d) times the radiance that is diffracted, summed over the lights.
fn glints(place: vec3f, normal: vec3f, tangent: vec4f, uv: vec2f) -> vec3f {
    let wr = in_frame(mesh_params.eye.xyz - place, normal, tangent, uv);
    if (shade.blend.w < 0.5) {
        return vec3f(0.0);
    }
    var sum = vec3f(0.0);
    for (var i = 0; i < i32(shade.counts.x); i++) {
        let wi = in_frame(shade.directions[i].xyz, normal, tangent, uv);
        let spread = footprint(wi, wr);
        if (wi.z > 0.0 && wr.z > 0.0) {
            sum += shade.blend.y / 3.1415927 * shade.powers[i].rgb * seen(wi, wr, spread);
        }
    }
    // the functions take away what is below the horizon
    for (var i = 0; i < i32(shade.counts.y); i++) {
        let axis = in_frame(shade.discs[i].xyz, normal, tangent, uv);
        let radius = shade.discs[i].w;
        let power = shade.powers[FIRST_DISC + i].rgb;
        let spread = footprint(axis, wr);
        if (IS_GGX && axis.z > 0.0 && wr.z > 0.0) {
            sum += power * ggx(axis, wr);
        }
        if (WIDENS && 4.0 * spread * spread > disc_variance(radius, axis.z)) {
            // the footprint hides the edge of the disc, so that both are one lobe
            let variance = disc_variance(radius, axis.z) + spread * spread;
            if (axis.z > 0.0 && wr.z > 0.0) {
                sum += shade.blend.y / 3.1415927 * power * lobe_of(axis, wr, variance);
            }
        } else if (!IS_GGX) {
            sum += diffraction_disc_coloured(axis, radius, power, wr);
        }
    }
    for (var i = 0; i < i32(shade.counts.z); i++) {
        // a fan of quadrilaterals; the last one may be a triangle
        let radiance = shade.powers[FIRST_POLYGON + i].rgb;
        let last = i32(shade.powers[FIRST_POLYGON + i].w) - 1;
        let a = corner(i, 0, normal, tangent, uv);
        for (var k = 1; k < last; k += 2) {
            let b = corner(i, k, normal, tangent, uv);
            let c = corner(i, k + 1, normal, tangent, uv);
            let d = corner(i, min(k + 2, last), normal, tangent, uv);
            sum += diffraction_rectangle_coloured(a, b, c, d, radiance, wr);
        }
    }
    return (1.0 - shade.blend.x) * (sum + glints_of_surroundings(normal, tangent, uv, wr));
}

// The axes of the world in the frame of the fragment, for `environment_radiance`.
var<private> world_x: vec3f;
var<private> world_y: vec3f;
var<private> world_z: vec3f;

// What is diffracted of skies and maps.
fn glints_of_surroundings(normal: vec3f, tangent: vec4f, uv: vec2f, wr: vec3f) -> vec3f {
    if (shade.counts.w == 0.0) {
        return vec3f(0.0);
    }
    world_x = in_frame(vec3f(1.0, 0.0, 0.0), normal, tangent, uv);
    world_y = in_frame(vec3f(0.0, 1.0, 0.0), normal, tangent, uv);
    world_z = in_frame(vec3f(0.0, 0.0, 1.0), normal, tangent, uv);
    return diffraction_environment(wr);
}

// Clamps to the range of 16-bit floats.
fn held(radiance: vec3f) -> vec3f {
    return clamp(radiance, vec3f(-6e4), vec3f(6e4));
}

// What is diffracted of a single direction, or what an ordinary material reflects.
fn seen(wi: vec3f, wr: vec3f, spread: f32) -> vec3f {
    if (IS_GGX) {
        return ggx(wi, wr);
    }
    if (WIDENS) {
        return diffraction_spread(wi, wr, spread);
    }
    return diffraction(wi, wr);
}

// Variance of a disc in direction cosines, on each axis.
fn disc_variance(radius: f32, cosine: f32) -> f32 {
    let sine = sin(radius);
    return 0.25 * sine * sine * max(cosine, 0.0);
}

// A white lobe of GGX for comparison, in an arbitrary unit.
fn ggx(wi: vec3f, wr: vec3f) -> vec3f {
    let squared = GGX_ALPHA * GGX_ALPHA;
    let half_vector = unit(wi + wr, 1e-8);
    let width = half_vector.z * half_vector.z * (squared - 1.0) + 1.0;
    let masking = wi.z * sqrt(wr.z * wr.z * (1.0 - squared) + squared) + wr.z * sqrt(wi.z * wi.z * (1.0 - squared) + squared);
    return vec3f(wi.z * squared / (width * width * max(masking, 1e-4)));
}

// Spread of the lobes by the footprint of the pixel; 0 if lobes are not widened.
fn footprint(wi: vec3f, wr: vec3f) -> f32 {
    let path = wi.xy + wr.xy;
    let spread = footprint_spread(dpdx(path), dpdy(path), min(wi.z, wr.z));
    return select(0.0, spread, WIDENS);
}

struct Parts {
    // rgb: diffracted radiance
    @location(0) glints: vec4f,
    // rgb: radiance of a white body
    @location(1) diffuse: vec4f,
}

// What the lights contribute, part by part, to be compared with the scene in 64 bits.
@fragment
fn scene_parts(
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
) -> Parts {
    let ratios = pattern_ratios(uv);
    let pattern = vec4f(1.0, 0.0, ratios.xy);
    let diffracted = ratios.z * glints(place, normal, tangent, uv);
    let white = diffuse(ratios.z, place, normal, tangent, uv);
    return Parts(vec4f(diffracted, 1.0), vec4f(white, 1.0));
}

struct Used {
    // xyz: direction to the light; w: distance from the viewer
    @location(0) wi: vec4f,
    // xyz: direction to the viewer; w: 1 plus the spread of lobes
    @location(1) wr: vec4f,
}

// The directions and the spread that the entry point `mesh` uses.
@fragment
fn scene_directions(
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
) -> Used {
    let wi = in_frame(mesh_params.light_direction.xyz, normal, tangent, uv);
    let wr = in_frame(mesh_params.eye.xyz - place, normal, tangent, uv);
    let path = wi.xy + wr.xy;
    let spread = footprint_spread(dpdx(path), dpdy(path), min(wi.z, wr.z));
    return Used(vec4f(wi, distance(mesh_params.eye.xyz, place)), vec4f(wr, 1.0 + spread));
}

struct Axes {
    // xyz: the world's x axis in the frame of the fragment; w: 1, or -1 if the frame is mirrored
    @location(0) x: vec4f,
    // xyz: the y axis; w: 1
    @location(1) y: vec4f,
}

// The frame into which lights are taken.
@fragment
fn scene_axes(
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
) -> Axes {
    let x = in_frame(vec3f(1.0, 0.0, 0.0), normal, tangent, uv);
    let y = in_frame(vec3f(0.0, 1.0, 0.0), normal, tangent, uv);
    let z = in_frame(vec3f(0.0, 0.0, 1.0), normal, tangent, uv);
    return Axes(vec4f(x, sign(dot(cross(x, y), z))), vec4f(y, 1.0));
}
