//- Twin: src/variant/twin/colour_path.rs.

// Random paths of light for path tracers. A path is a path difference (u, v), which gives one direction to the light. It
// stands for all wavelengths.

// A binary tree over the disc |(u, v)| ≤ 2. Node 1 is all of it; the halves of node n are 2n and 2n + 1. Channels: 0 where
// the angle is divided and 1 where the radius is; the place of the division; the probability of the half below it.
@group(0) @binding(10) var paths: texture_2d<f32>;

// A path from three random numbers, 0 to 1, of which it uses two: the direction to the light, and 0. z of the direction is
// 0 where no light comes from there; such a path has no weight.
fn diffraction_path(wr: vec3f, random: vec3f) -> vec4f {
    var low = vec2f(0.0);
    var high = vec2f(1.0);
    var rest = clamp(random.xy, vec2f(0.0), vec2f(0.9999999));
    var node = 1;
    for (var level = 0; level < PATH_LEVELS; level++) {
        let half = path_half(node);
        let is_radius = half.x > 0.5;
        let number = select(rest.x, rest.y, is_radius);
        let is_above = number >= half.z;
        // what is left of the random number is random again
        let above = (number - half.z) / max(1.0 - half.z, 1e-20);
        let left = select(number / max(half.z, 1e-20), above, is_above);
        rest = select(vec2f(left, rest.y), vec2f(rest.x, left), is_radius);
        let axis = vec2<bool>(!is_radius, is_radius);
        low = select(low, vec2f(half.y), axis & vec2<bool>(is_above));
        high = select(high, vec2f(half.y), axis & vec2<bool>(!is_above));
        node = 2 * node + select(0, 1, is_above);
    }
    let place = mix(low, high, rest);
    let angle = 6.2831853 * (place.x - 0.5);
    let radius = 2.0 * sqrt(place.y);
    let uv = radius * vec2f(cos(angle), sin(angle));
#ifdef ROTATED
    let turn = textureLoad(spectrum, vec2i(0, 1), 0);
    let plane = -wr.xy - vec2f(turn.x * uv.x - turn.y * uv.y, turn.x * uv.y + turn.y * uv.x);
#else
    let plane = -wr.xy - uv;
#endif
    return vec4f(plane, sqrt(max(0.0, 1.0 - dot(plane, plane))), 0.0);
}

// X, Y, Z of a path's weight: its light divided by its probability.
fn tristimulus_weight(wr: vec3f, path: vec4f) -> vec3f {
    if (!(wr.z > 1e-6 && path.z > 1e-6)) {
        return vec3f(0.0);
    }
    let chance = path_density(path_difference(path.xyz, wr).xy) * path.z;
    return RADIANCE_SCALE / chance * tristimulus(path.xyz, wr);
}

// Probability per area of (u, v).
fn path_density(uv: vec2f) -> f32 {
    let turn = atan2(uv.y, uv.x + select(0.0, 1e-20, all(uv == vec2f(0.0)))) / 6.2831853 + 0.5;
    let place = vec2f(turn, 0.25 * dot(uv, uv));
    var low = vec2f(0.0);
    var high = vec2f(1.0);
    var chance = 1.0;
    var node = 1;
    for (var level = 0; level < PATH_LEVELS; level++) {
        let half = path_half(node);
        let is_radius = half.x > 0.5;
        let is_above = select(place.x, place.y, is_radius) >= half.y;
        chance *= select(half.z, 1.0 - half.z, is_above);
        let axis = vec2<bool>(!is_radius, is_radius);
        low = select(low, vec2f(half.y), axis & vec2<bool>(is_above));
        high = select(high, vec2f(half.y), axis & vec2<bool>(!is_above));
        node = 2 * node + select(0, 1, is_above);
    }
    let sides = high - low;
    return chance / max(12.566371 * sides.x * sides.y, 1e-20);
}

// The division of a node.
fn path_half(node: i32) -> vec4f {
    let row = node / PATH_COLUMNS;
    return textureLoad(paths, vec2i(node - row * PATH_COLUMNS, row), 0);
}
