//- Twin: src/variant/twin/window.rs.

// The spectrum of the coherence window. The window is a Gaussian whose standard deviation is a quarter of the coherence
// length.

// 1/(2σ²) of the window's spectrum along x and y, σ in bins.
fn window_sharpness(lambda_um: f32) -> vec2f {
    var sigma_um = 0.25 * COHERENCE_UM;
#ifdef COHERENCE_SCALES
    // a source of fixed angular size
    sigma_um *= lambda_um / REFERENCE_UM;
#endif
    let turns = 6.2831853 * sigma_um / vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
    return 0.5 * turns * turns;
}

// Weight of a bin's amplitude at an offset in bins, 0 to 1.
fn window(offset: vec2f, sharpness: vec2f) -> f32 {
    return exp(-dot(offset * offset, sharpness));
}
