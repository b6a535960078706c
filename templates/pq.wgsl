//- Twin: src/variant/twin/pq.rs.

// A finite number of replicas of the patch, without a coherence window: the transform of one patch, interpolated
// between the bins, times the interference of the replicas.

// |P|² at one wavelength in µm, relative to a mirror.
fn response(path: vec3f, lambda_um: f32) -> f32 {
    let place = path.xy / lambda_um * vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
    let first = floor(place - 0.5 * vec2f(f32(TAP_COLUMNS - 1), f32(TAP_ROWS - 1)) + 0.5);
    let tau = series_argument(path.z, lambda_um);
    var amplitude = vec2f(0.0);
    for (var s = 0; s < TAP_ROWS; s++) {
        let row = first.y + f32(s);
        let weight = kernel(place.y - row, PIXEL_ROWS);
        for (var r = 0; r < TAP_COLUMNS; r++) {
            let column = first.x + f32(r);
            let tap = complex_product(weight, kernel(place.x - column, PIXEL_COLUMNS));
            amplitude += complex_product(tap, bin_amplitude(vec2i(vec2f(column, row)), tau));
        }
    }
    let factor = replica_factor(place.x, PERIOD_COLUMNS) * replica_factor(place.y, PERIOD_ROWS);
#ifdef HALF
    amplitude *= series_scale();
#endif
    return factor * factor * dot(amplitude, amplitude);
}

// Interpolation weight of a bin at an offset t in bins, for N pixels: the periodic sinc, with a phase because the
// middle of the pixels is half a pixel before the patch's centre, e^(-iπt/N) sin πt / (N sin(πt/N)).
fn kernel(offset: f32, pixels: f32) -> vec2f {
    let part = offset / pixels;
    let half_sine = 1.5707964 * part * sinc(0.5 * part);
    let cosine = 1.0 - 2.0 * half_sine * half_sine;
    return vec2f(sinc(offset) / sinc(part) * cosine, -3.1415927 * part * sinc(offset));
}

// Interference of Q replicas at t in bins: sin(πQt) / (Q sin πt) up to its sign, 1 at whole t.
fn replica_factor(place: f32, periods: f32) -> f32 {
    let rest = place - floor(place + 0.5);
    return sinc(periods * rest) / sinc(rest);
}

// sin πt / (πt). The sine is a series from -π/2 to π/2, because a built-in sine is too coarse for a quotient of small
// sines: Vulkan allows an absolute error of 2^-11.
fn sinc(turns: f32) -> f32 {
    let nearest = floor(turns + 0.5);
    let rest = turns - nearest;
    let squared = 9.869604 * rest * rest;
    let outer = 1.0 - squared / 72.0 * (1.0 - squared / 110.0 * (1.0 - squared / 156.0));
    let near = 1.0 - squared / 6.0 * (1.0 - squared / 20.0 * (1.0 - squared / 42.0 * outer));
    if (nearest == 0.0) {
        return near;
    }
    let odd = nearest - 2.0 * floor(0.5 * nearest);
    return (1.0 - 2.0 * odd) * rest / turns * near;
}

// Product of two complex numbers, x real and y imaginary.
fn complex_product(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}
