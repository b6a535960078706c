//- Algorithm 3.3 of the texts, as it is printed, for `hoist = false`. Nothing is moved out of a loop, on purpose.
//- Twin: src/variant/twin/full.rs. Both templates compute the same sum in another order and share the twin.

// The full sum, term by term: for each term, the sum over all bins within a radius of the nearest one. The window's
// weights are computed again for each term.

// |P|² at one wavelength in µm, relative to a mirror.
fn response(path: vec3f, lambda_um: f32) -> f32 {
    let place = path.xy / lambda_um * vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
    let nearest = floor(place + 0.5);
    let tau = series_argument(path.z, lambda_um);
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
#ifdef HALF
    return series_scale() * series_scale() * squared;
#else
    return squared;
#endif
}
