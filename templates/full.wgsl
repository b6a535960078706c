// The full sum: uniform wavelengths, all bins within a radius of the nearest one, a power series per bin.

// Transforms of the terms at the bins that can be reached; the middle texel is bin (0, 0).
@group(0) @binding(1) var terms: texture_2d_array<f32>;
// Row 0: X, Y, Z weights and wavelength in µm of each node; row 1: cosine and sine of the surface's rotation.
@group(0) @binding(2) var spectrum: texture_2d<f32>;

// Relative tristimulus values for one pair of directions.
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    let factor = gain(wi, wr);
    if (factor == 0.0) {
        return vec3f(0.0);
    }
    let path = path_difference(wi, wr);
    var xyz = vec3f(0.0);
    for (var node = 0; node < WAVELENGTH_COUNT; node++) {
        let sample = textureLoad(spectrum, vec2i(node, 0), 0);
        xyz += sample.xyz * response(path, sample.w);
    }
    return factor * xyz;
}

// |P|² at one wavelength, in µm.
fn response(path: vec3f, lambda_um: f32) -> f32 {
    let place = path.xy / lambda_um * vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
    let nearest = floor(place + 0.5);
    // z over its greatest value
    let tau = 0.5 * path.z * WAVELENGTH_MIN_UM / lambda_um;
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
    return intensity;
#else
    return dot(amplitude, amplitude);
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
    return dot(amplitude, amplitude);
#endif
}

#ifdef HOIST
// The transform of the phase function at one bin: the sum over terms of τ^n times the table, by Horner's rule.
fn bin_amplitude(bin: vec2i, tau: f32) -> vec2f {
    let texel = bin + vec2i(CENTRE_COLUMN, CENTRE_ROW);
#ifdef PAIRED
    // even and odd powers side by side
    let step = tau * tau;
    var sum = vec4f(0.0);
    for (var layer = LAYER_COUNT - 1; layer >= 0; layer--) {
        sum = sum * step + textureLoad(terms, texel, layer, 0);
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
