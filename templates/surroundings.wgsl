//- f64 form: `Filtered` in src/light/environment/filtered.rs.

// The surroundings of whole shaders. In function forms this function is the host's.

// Levels of a panorama, one below the other, each blurred over twice the angle of the one above. Columns go once round from
// the tangent's opposite; rows go from the normal to its opposite. Each level has a frame of one texel: columns of the other
// side, and rows as those beside them. rgb: linear sRGB.
@group(0) @binding(7) var environment: texture_2d<f32>;
#ifdef FILTERED
#else
// Linear filter, clamped to the edge.
@group(0) @binding(5) var linear_clamp: sampler;
#endif

// Radiance of the surroundings, linear sRGB, from a unit direction in the tangent frame, blurred to a standard deviation of
// `spread` radians on each axis.
fn environment_radiance(direction: vec3f, spread: f32) -> vec3f {
    let across = length(direction.xy);
    let place = vec2f(
        atan2(direction.y, direction.x + select(0.0, 1e-12, across == 0.0)) / 6.2831853 + 0.5,
        atan2(across, direction.z) / 3.1415927,
    );
    let blur = spread * spread / (FIRST_SPREAD * FIRST_SPREAD);
    if (blur < 1.0) {
        return mix(environment_level(0, place), environment_level(1, place), blur);
    }
    let level = clamp(i32(floor(0.5 * log2(blur))) + 1, 1, ENVIRONMENT_LEVELS - 2);
    let own = exp2(2.0 * f32(level - 1));
    let share = clamp((blur - own) / (3.0 * own), 0.0, 1.0);
    return mix(environment_level(level, place), environment_level(level + 1, place), share);
}

// A level at a place: parts of a turn, and of half a turn from the normal.
fn environment_level(level: i32, place: vec2f) -> vec3f {
    let rows = f32(ENVIRONMENT_ROWS >> u32(max(level - 1, 0)));
    let most = f32(ENVIRONMENT_ROWS);
    let above = select(0.0, 3.0 * most + 2.0 * f32(level) - 2.0 * rows, level > 0);
    let texel = vec2f(1.0 + 2.0 * rows * place.x, above + 1.0 + rows * place.y);
    let size = vec2f(2.0 * most + 2.0, f32(ENVIRONMENT_HEIGHT));
    return textureSampleLevel(environment, linear_clamp, texel / size, 0.0).xyz;
}
