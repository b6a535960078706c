// The spectrum of the coherence window.

// 1/(2σ²) of the window on each axis, in bins.
fn window_sharpness(lambda_um: f32) -> vec2f {
    var sigma_um = 0.25 * COHERENCE_UM;
#ifdef COHERENCE_SCALES
    // a source of fixed angular size; the coherence length is stated at 0.55 µm
    sigma_um *= lambda_um / 0.55;
#endif
    let turns = 6.2831853 * sigma_um / vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
    return 0.5 * turns * turns;
}

// Weight of the coherence window at an offset in bins, peak 1.
fn window(offset: vec2f, sharpness: vec2f) -> f32 {
    return exp(-dot(offset * offset, sharpness));
}
