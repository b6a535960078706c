//- Twin: src/variant/twin/environment.rs.

// Orders under surroundings. As the wavelength varies, an order takes light from a streak of directions. The streak is
// divided into cells of wavelengths. Each asks for the radiance at one wavelength, blurred over the cell's part of the
// streak, and weighs it with the light of the cells around that wavelength.

// Columns: cells from short wavelengths to long ones, then the upper edge of the last; after that the same with twice as
// many cells. Row: red, green, blue light. Channels: X, Y, Z of that light about the wavelength of the cell; then in row 0
// the wavelength in µm, in row 1 the lower edge of the cell, in row 2 the spread of its wavelengths.
@group(0) @binding(6) var streaks: texture_2d<f32>;

// X, Y, Z of the radiance under the surroundings, relative to a white of radiance 1.
fn tristimulus_environment(wr: vec3f) -> vec3f {
    if (!(wr.z > 1e-6)) {
        return vec3f(0.0);
    }
    let viewer = in_surface(wr);
    var xyz = mirror_image(viewer);
    for (var row = -ORDER_REACH_Y; row <= ORDER_REACH_Y; row++) {
        for (var column = -ORDER_REACH_X; column <= ORDER_REACH_X; column++) {
            if (row != 0 || column != 0) {
                xyz += streak(vec2i(column, row), viewer);
            }
        }
    }
    return normal_reflectance() * xyz;
}

// X, Y, Z of the order that mirrors: all wavelengths come from one direction.
fn mirror_image(wr: vec3f) -> vec3f {
    var red = vec3f(0.0);
    var green = vec3f(0.0);
    var blue = vec3f(0.0);
    for (var cell = 0; cell < STREAK_CELLS; cell++) {
        let of_red = streak_light(cell, 0);
        let share = order_share(vec2i(0, 0), vec2f(0.0), of_red.w, wr);
        red += share * of_red.xyz;
        green += share * streak_light(cell, 1).xyz;
        blue += share * streak_light(cell, 2).xyz;
    }
    let light = environment_radiance(from_surface(vec3f(-wr.xy, wr.z)), 0.0);
    return light.x * red + light.y * green + light.z * blue;
}

// X, Y, Z of another order.
fn streak(order: vec2i, wr: vec3f) -> vec3f {
    let frequency = order_frequency(order);
    let range = propagating(frequency, wr);
    let pace = length(frequency);
    // long streaks have the finer cells
    let is_long = pace > LONG_CPUM;
    let first = select(0, STREAK_CELLS + 1, is_long);
    let end = first + select(STREAK_CELLS, 2 * STREAK_CELLS, is_long);
    var xyz = vec3f(0.0);
    var first_um = streak_light(first, 1).w;
    for (var cell = first; cell < end; cell++) {
        let last_um = streak_light(cell + 1, 1).w;
        let low = max(first_um, range.x);
        let high = min(last_um, range.y);
        if (low < high) {
            let part = (high - low) / (last_um - first_um);
            let red = streak_light(cell, 0);
            // in a cell that the horizon cuts: in the middle of what is left
            let inner = clamp(red.w, mix(low, high, 0.3), mix(low, high, 0.7));
            let lambda_um = select(red.w, inner, part < 0.999);
            let share = part * order_share(order, frequency, lambda_um, wr);
            // weaker orders do not show
            if (share > 1e-6) {
                let wi = arrival(frequency, lambda_um, wr);
                let blue = streak_light(cell, 2);
                let spread = part * blue.w * pace * inverseSqrt(max(wi.z, 1e-4));
                let light = share * environment_radiance(from_surface(wi), spread);
                let green = streak_light(cell, 1);
                xyz += light.x * red.xyz + light.y * green.xyz + light.z * blue.xyz;
            }
        }
        first_um = last_um;
    }
    return xyz;
}

// Light of a cell. Row: red, green, blue.
fn streak_light(cell: i32, row: i32) -> vec4f {
    return textureLoad(streaks, vec2i(cell, row), 0);
}
