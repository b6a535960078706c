//- Twin: src/variant/twin/prefiltered.rs.

// The amplitude from a table whose terms were multiplied by the coherence window before their transform.

#ifdef FILTERED
// Linear filter, clamped to the edge.
@group(0) @binding(5) var linear_clamp: sampler;

#endif
#ifdef MODE_FULL
// |P|² at one wavelength in µm, relative to a mirror.
fn response(path: vec3f, lambda_um: f32) -> f32 {
#ifdef HALF
    return series_scale() * series_scale() * intensity(path, lambda_um);
#else
    return intensity(path, lambda_um);
#endif
}

#endif
#ifdef HALF
// |P|² at one wavelength in µm, divided by the squared scale of the first term.
#else
// |P|² at one wavelength in µm, relative to a mirror.
#endif
fn intensity(path: vec3f, lambda_um: f32) -> f32 {
    let place = path.xy / lambda_um * vec2f(GRID_WIDTH_UM, GRID_HEIGHT_UM);
    let sum = amplitude(place, series_argument(path.z, lambda_um));
    return dot(sum, sum);
}

#ifdef TABULATED
// The complex amplitude at a place in texels from the central texel: the sum of coefficient times term. The
// coefficients come from the nearest column.
fn amplitude(place: vec2f, argument: f32) -> vec2f {
    let index = i32(argument + 0.5);
    var sum = vec2f(0.0);
    for (var row = 0; row < COEFFICIENT_ROWS; row++) {
        let four = textureLoad(coefficients, vec2i(index, row), 0);
#ifdef PAIRED
        let first = texel_between(place, 2 * row);
        sum += four.x * first.xy + four.y * first.zw;
        if (2 * row + 1 < LAYER_COUNT) {
            let second = texel_between(place, 2 * row + 1);
            sum += four.z * second.xy + four.w * second.zw;
        }
#else
        sum += four.x * texel_between(place, 4 * row).xy;
        if (4 * row + 1 < LAYER_COUNT) {
            sum += four.y * texel_between(place, 4 * row + 1).xy;
        }
        if (4 * row + 2 < LAYER_COUNT) {
            sum += four.z * texel_between(place, 4 * row + 2).xy;
        }
        if (4 * row + 3 < LAYER_COUNT) {
            sum += four.w * texel_between(place, 4 * row + 3).xy;
        }
#endif
    }
    return sum;
}
#else
// The complex amplitude at a place in texels from the central texel: the sum of τ^n times term n, by Horner's rule.
fn amplitude(place: vec2f, argument: f32) -> vec2f {
#ifdef PAIRED
    // even and odd powers side by side
    let squared = argument * argument;
    var sum = vec4f(0.0);
    for (var layer = LAYER_COUNT - 1; layer >= 0; layer--) {
        sum = sum * squared + texel_between(place, layer);
    }
    return sum.xy + argument * sum.zw;
#else
    var sum = vec2f(0.0);
    for (var layer = LAYER_COUNT - 1; layer >= 0; layer--) {
        sum = sum * argument + texel_between(place, layer).xy;
    }
    return sum;
#endif
}
#endif

// A layer of the terms, bilinear between texels. Places are counted from the centre of the central texel.
fn texel_between(place: vec2f, layer: i32) -> vec4f {
#ifdef FILTERED
    let size = vec2f(f32(2 * CENTRE_COLUMN + 1), f32(2 * CENTRE_ROW + 1));
    return textureSampleLevel(terms, linear_clamp, place / size + 0.5, layer, 0.0);
#else
    let first = vec2i(floor(place)) + vec2i(CENTRE_COLUMN, CENTRE_ROW);
    let part = place - floor(place);
    let lower_left = textureLoad(terms, first, layer, 0);
    let lower_right = textureLoad(terms, first + vec2i(1, 0), layer, 0);
    let upper_left = textureLoad(terms, first + vec2i(0, 1), layer, 0);
    let upper_right = textureLoad(terms, first + vec2i(1, 1), layer, 0);
    return mix(mix(lower_left, lower_right, part.x), mix(upper_left, upper_right, part.x), part.y);
#endif
}
