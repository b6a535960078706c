//- Twin: src/variant/twin/series.rs.

#ifdef TABULATED
// The amplitude is a series of terms whose coefficients are a table.
#else
// The amplitude is a power series.
#endif

#ifdef PREFILTERED
// Transforms of the terms, multiplied by the coherence window, at the frequencies that light can reach. The central
// texel is frequency 0.
#else
// Transforms of the terms at the bins that light can reach. The central texel is bin (0, 0).
#endif
@group(0) @binding(1) var terms: texture_2d_array<f32>;

#ifdef TABULATED
// Coefficients of the terms, four in a texel. Columns are equal steps of the phase per height z = 2πw/λ, from its
// minimum to 0.
@group(0) @binding(4) var coefficients: texture_2d<f32>;

// Argument of the series: the column in the table of coefficients, from 0.
fn series_argument(w: f32, lambda_um: f32) -> f32 {
#ifdef COVER
#ifdef DISPERSION
    let tau = 0.5 * dispersed(w, lambda_um) * PHASE_MIN_UM / lambda_um;
#else
    let tau = 0.5 * w * PHASE_MIN_UM / lambda_um;
#endif
#else
    let tau = 0.5 * w * WAVELENGTH_MIN_UM / lambda_um;
#endif
    return clamp(1.0 + tau, 0.0, 1.0) * f32(COEFFICIENT_COUNT - 1);
}
#else
#ifdef HALF
// Argument τ of the series: w/λ relative to its largest magnitude, -1 to 0, times the ratio of the terms' scales.
#else
// Argument τ of the series: w/λ relative to its largest magnitude, -1 to 0.
#endif
fn series_argument(w: f32, lambda_um: f32) -> f32 {
#ifdef COVER
#ifdef DISPERSION
    let tau = 0.5 * dispersed(w, lambda_um) * PHASE_MIN_UM / lambda_um;
#else
    let tau = 0.5 * w * PHASE_MIN_UM / lambda_um;
#endif
#else
    let tau = 0.5 * w * WAVELENGTH_MIN_UM / lambda_um;
#endif
#ifdef HALF
    // terms are stored divided by a geometric sequence of scales
    return tau * textureLoad(spectrum, vec2i(0, 1), 0).w;
#else
    return tau;
#endif
}
#endif

#ifdef HALF
// Scale of the first term; the stored terms are divided by theirs.
fn series_scale() -> f32 {
    return textureLoad(spectrum, vec2i(0, 1), 0).z;
}
#endif
