// The transform of the phase function at one bin, as a power series.

// Transforms of the terms at the bins that can be reached; the middle texel is bin (0, 0).
@group(0) @binding(1) var terms: texture_2d_array<f32>;

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

#ifdef HALF
// Scale of the first term.
fn series_scale() -> f32 {
    return textureLoad(spectrum, vec2i(0, 1), 0).z;
}
#endif

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
