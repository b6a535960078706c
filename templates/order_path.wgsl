//- Twin: src/variant/twin/order_path.rs.

// Random paths of light for path tracers. A path is an order and a wavelength, which give one direction to the light.

// Row 0, one column for each order: threshold and other order of an alias table, and the probability. Rows 1 and 2, one
// column for each edge of equal cells of wavelengths: the probability of all shorter ones, then X, Y, Z there times the
// width of a cell; the probability of the cell that begins there, then the shares of red, green and blue light.
@group(0) @binding(10) var paths: texture_2d<f32>;

// A path from three random numbers, 0 to 1: the direction to the light, and the wavelength in µm. z of the direction is 0
// where the order does not propagate; such a path has no weight.
fn diffraction_path(wr: vec3f, random: vec3f) -> vec4f {
    let viewer = in_surface(wr);
    let lambda_um = drawn_wavelength(random.z);
    let wi = arrival(order_frequency(drawn_order(random.xy)), lambda_um, viewer);
    return vec4f(from_surface(wi), lambda_um);
}

// Light of a linear RGB colour at a wavelength in µm, relative to white light.
fn diffraction_light(rgb: vec3f, lambda_um: f32) -> f32 {
    let place = wavelength_place(lambda_um);
    let cell = wavelength_cell(place);
    let before = textureLoad(paths, vec2i(cell, 2), 0).yzw;
    let after = textureLoad(paths, vec2i(cell + 1, 2), 0).yzw;
    return dot(rgb, mix(before, after, place - f32(cell)));
}

// X, Y, Z of a path's weight: its light divided by its probability.
fn tristimulus_weight(wr: vec3f, path: vec4f) -> vec3f {
    if (!(wr.z > 1e-6 && path.z > 1e-6 && path.w > 0.0)) {
        return vec3f(0.0);
    }
    let viewer = in_surface(wr);
    let shift = -in_surface(path.xyz).xy - viewer.xy;
#ifdef PATTERN
    let patch_um = pattern.z * vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
#else
    let patch_um = vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
#endif
    let order = vec2i(floor(shift / path.w * patch_um + 0.5));
    let reach = vec2i(ORDER_REACH_X, ORDER_REACH_Y);
    if (any(abs(order) > reach)) {
        return vec3f(0.0);
    }
    let column = (order.y + reach.y) * (2 * reach.x + 1) + order.x + reach.x;
    let chance = textureLoad(paths, vec2i(column, 0), 0).z;
    let place = wavelength_place(path.w);
    let cell = wavelength_cell(place);
    let before = textureLoad(paths, vec2i(cell, 1), 0).yzw;
    let after = textureLoad(paths, vec2i(cell + 1, 1), 0).yzw;
    let light = mix(before, after, place - f32(cell)) / textureLoad(paths, vec2i(cell, 2), 0).x;
    let share = order_share(order, order_frequency(order), path.w, viewer);
    return normal_reflectance() * share / chance * light;
}

// An order by the alias method.
fn drawn_order(random: vec2f) -> vec2i {
    let column = min(i32(random.x * f32(ORDER_COUNT)), ORDER_COUNT - 1);
    let pair = textureLoad(paths, vec2i(column, 0), 0);
    let chosen = select(i32(pair.y), column, random.y < pair.x);
    let width = 2 * ORDER_REACH_X + 1;
    let row = chosen / width;
    return vec2i(chosen - row * width - ORDER_REACH_X, row - ORDER_REACH_Y);
}

// A wavelength in µm: the inverse of the sum of probabilities, whose cell is found by halving.
fn drawn_wavelength(random: f32) -> f32 {
    var cell = 0;
    var end = PATH_CELLS;
    while (end - cell > 1) {
        let middle = (cell + end) / 2;
        if (textureLoad(paths, vec2i(middle, 1), 0).x <= random) {
            cell = middle;
        } else {
            end = middle;
        }
    }
    let below = textureLoad(paths, vec2i(cell, 1), 0).x;
    let chance = textureLoad(paths, vec2i(cell, 2), 0).x;
    let part = clamp((random - below) / chance, 0.0, 1.0);
    return mix(WAVELENGTH_MIN_UM, WAVELENGTH_MAX_UM, (f32(cell) + part) / f32(PATH_CELLS));
}

// Place of a wavelength in cells.
fn wavelength_place(lambda_um: f32) -> f32 {
    let share = (lambda_um - WAVELENGTH_MIN_UM) / (WAVELENGTH_MAX_UM - WAVELENGTH_MIN_UM);
    return clamp(share, 0.0, 1.0) * f32(PATH_CELLS);
}

// The cell at a place.
fn wavelength_cell(place: f32) -> i32 {
    return min(i32(place), PATH_CELLS - 1);
}
