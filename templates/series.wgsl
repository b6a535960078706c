#ifdef PREFILTERED
// The terms of the amplitude, and what their series is in.
#else
#ifdef TABULATED
// The transform of the phase function at one bin, as a series whose coefficients are a table.
#else
// The transform of the phase function at one bin, as a power series.
#endif
#endif

#ifdef PREFILTERED
// Transforms of the terms under the coherence window at the frequencies that can be reached; the middle texel is 0.
#else
// Transforms of the terms at the bins that can be reached; the middle texel is bin (0, 0).
#endif
@group(0) @binding(1) var terms: texture_2d_array<f32>;

#ifdef TABULATED
// Coefficients of the terms, four to a texel: columns are equal steps of z from its least value to 0.
@group(0) @binding(4) var coefficients: texture_2d<f32>;

// What the series is in: the place in the table.
fn series_argument(w: f32, lambda_um: f32) -> f32 {
    let tau = 0.5 * w * WAVELENGTH_MIN_UM / lambda_um;
    return clamp(1.0 + tau, 0.0, 1.0) * f32(COEFFICIENT_COUNT - 1);
}
#else
// What the series is in: z over its greatest value.
fn series_argument(w: f32, lambda_um: f32) -> f32 {
    let tau = 0.5 * w * WAVELENGTH_MIN_UM / lambda_um;
#ifdef HALF
    // terms are stored over a geometric sequence of scales
    return tau * textureLoad(spectrum, vec2i(0, 1), 0).w;
#else
    return tau;
#endif
}
#endif

#ifdef HALF
// Scale of the first term.
fn series_scale() -> f32 {
    return textureLoad(spectrum, vec2i(0, 1), 0).z;
}
#endif

#ifndef PREFILTERED
#ifdef TABULATED
// The sum over terms of coefficient times table, coefficients linear between their nodes; of scaled tables, over their
// scale.
fn bin_amplitude(bin: vec2i, place: f32) -> vec2f {
    let texel = bin + vec2i(CENTRE_COLUMN, CENTRE_ROW);
    let index = min(i32(place), COEFFICIENT_COUNT - 2);
    var sum = vec2f(0.0);
    for (var row = 0; row < COEFFICIENT_ROWS; row++) {
        let before = textureLoad(coefficients, vec2i(index, row), 0);
        let after = textureLoad(coefficients, vec2i(index + 1, row), 0);
        let four = mix(before, after, place - f32(index));
#ifdef PAIRED
        let first = textureLoad(terms, texel, 2 * row, 0);
        sum += four.x * first.xy + four.y * first.zw;
        if (2 * row + 1 < LAYER_COUNT) {
            let second = textureLoad(terms, texel, 2 * row + 1, 0);
            sum += four.z * second.xy + four.w * second.zw;
        }
#else
        sum += four.x * textureLoad(terms, texel, 4 * row, 0).xy;
        if (4 * row + 1 < LAYER_COUNT) {
            sum += four.y * textureLoad(terms, texel, 4 * row + 1, 0).xy;
        }
        if (4 * row + 2 < LAYER_COUNT) {
            sum += four.z * textureLoad(terms, texel, 4 * row + 2, 0).xy;
        }
        if (4 * row + 3 < LAYER_COUNT) {
            sum += four.w * textureLoad(terms, texel, 4 * row + 3, 0).xy;
        }
#endif
    }
    return sum;
}
#else
#ifdef HOIST
// The sum over terms of τ^n times the table, by Horner's rule; of scaled tables, over the scale of the first term.
fn bin_amplitude(bin: vec2i, tau: f32) -> vec2f {
    let texel = bin + vec2i(CENTRE_COLUMN, CENTRE_ROW);
#ifdef PAIRED
    // even and odd powers side by side
    let tau_squared = tau * tau;
    var sum = vec4f(0.0);
    for (var layer = LAYER_COUNT - 1; layer >= 0; layer--) {
        sum = sum * tau_squared + textureLoad(terms, texel, layer, 0);
    }
    return sum.xy + tau * sum.zw;
#else
    var sum = vec2f(0.0);
    for (var layer = LAYER_COUNT - 1; layer >= 0; layer--) {
        sum = sum * tau + textureLoad(terms, texel, layer, 0).xy;
    }
    return sum;
#endif
}
#endif
#endif
#endif
