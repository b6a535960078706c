// The full sum: all bins within a radius of the nearest one, under the coherence window.

// |P|² at one wavelength, in µm.
fn response(path: vec3f, lambda_um: f32) -> f32 {
    let place = path.xy / lambda_um * vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
    let nearest = floor(place + 0.5);
    let tau = series_argument(path.z, lambda_um);
#ifdef HOIST
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
#else
    // Term by term, the window's weights computed anew for each, as Algorithm 3.3 of the texts is printed.
    var amplitude = vec2f(0.0);
    var power = 1.0;
    for (var layer = 0; layer < LAYER_COUNT; layer++) {
#ifdef PAIRED
        var transform = vec4f(0.0);
#else
        var transform = vec2f(0.0);
#endif
        for (var r = -WINDOW_RADIUS; r <= WINDOW_RADIUS; r++) {
            for (var s = -WINDOW_RADIUS; s <= WINDOW_RADIUS; s++) {
                let bin = nearest + vec2f(f32(r), f32(s));
                let weight = window(place - bin, window_sharpness(lambda_um));
                let texel = textureLoad(terms, vec2i(bin) + vec2i(CENTRE_COLUMN, CENTRE_ROW), layer, 0);
#ifdef PAIRED
                transform += weight * texel;
#else
                transform += weight * texel.xy;
#endif
            }
        }
#ifdef PAIRED
        amplitude += power * (transform.xy + tau * transform.zw);
        power *= tau * tau;
#else
        amplitude += power * transform;
        power *= tau;
#endif
    }
    let squared = dot(amplitude, amplitude);
#endif
#ifdef HALF
    return series_scale() * series_scale() * squared;
#else
    return squared;
#endif
}
