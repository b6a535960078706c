//- Twin: src/variant/twin/full.rs. `thesis` is the same sum in another order.

// The full sum: all bins within a radius of the nearest one, weighted by the coherence window.

// |P|² at one wavelength in µm, relative to a mirror.
fn response(path: vec3f, lambda_um: f32) -> f32 {
    let place = path.xy / lambda_um * vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
    let nearest = floor(place + 0.5);
    let tau = series_argument(path.z, lambda_um);
    let sharpness = window_sharpness(lambda_um);
#ifdef ENSEMBLE
    var intensity = 0.0;
#else
    var amplitude = vec2f(0.0);
#endif
    for (var s = -WINDOW_RADIUS; s <= WINDOW_RADIUS; s++) {
        for (var r = -WINDOW_RADIUS; r <= WINDOW_RADIUS; r++) {
            let bin = nearest + vec2f(f32(r), f32(s));
            let tap = bin_amplitude(vec2i(bin), tau) * window(place - bin, sharpness);
#ifdef ENSEMBLE
            intensity += dot(tap, tap);
#else
            amplitude += tap;
#endif
        }
    }
#ifdef ENSEMBLE
    let squared = intensity;
#else
    let squared = dot(amplitude, amplitude);
#endif
#ifdef HALF
    return series_scale() * series_scale() * squared;
#else
    return squared;
#endif
}
