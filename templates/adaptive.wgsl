// The wavelength integral as a sum over bins: as λ runs over its range, f = (u, v)/λ walks a straight segment, and only
// bins within a few widths of the window's spectrum see it. Wavenumbers 1/λ are in 1/µm, frequencies in cycles per µm.

// Row 0: at equal steps of 1/λ, from the longest wavelength to the shortest, X, Y, Z per 1/µm and the wavelength in µm;
// row 1: cosine and sine of the surface's rotation, scale of the first term, ratio of the scales.
@group(0) @binding(2) var spectrum: texture_2d<f32>;

// Lobes end at this many standard deviations of the window's spectrum.
const REACH_SIGMAS: f32 = 4.0;
// Whole lobes this many panels wide are not cut.
const WHOLE_PANELS: f32 = 2.5;
// Nodes of a panel.
const NODE_COUNT: i32 = 8;

// Relative tristimulus values for one pair of directions.
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    let factor = gain(wi, wr);
    if (factor == 0.0) {
        return vec3f(0.0);
    }
    return factor * corridor(path_difference(wi, wr));
}

#ifdef MONOCHROMATIC
// A bin's intensity under the window at one wavelength.
fn intensity(bin: vec2f, path: vec3f, lambda_um: f32) -> f32 {
    let amplitude = bin_amplitude(vec2i(bin), series_argument(path.z, lambda_um));
    return dot(amplitude, amplitude) * window_share(bin, path.xy, 1.0 / lambda_um);
}
#endif

// The sum over the bins of a strip along the segment: columns one by one and the few rows across, or the other way where
// the segment is steep.
fn corridor(path: vec3f) -> vec3f {
    let steep = abs(path.y) > abs(path.x);
    let patch_um = vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
    let along = select(path.xy, path.yx, steep);
    let size_um = select(patch_um, patch_um.yx, steep);
    let slope = along.y / select(along.x, 1.0, along.x == 0.0);
    let range = wavenumbers();
    let reach = REACH_SIGMAS * window_width(range.y);
    let half_width = reach * sqrt(1.0 + slope * slope);
    let ends = along.x * range;
    let first = ceil((min(ends.x, ends.y) - reach) * size_um.x);
    let last = floor((max(ends.x, ends.y) + reach) * size_um.x);
    var xyz = vec3f(0.0);
    for (var i = 0; i < MAJOR_COUNT; i++) {
        let major = first + f32(i);
        if (major > last) {
            break;
        }
        let centre = slope * major / size_um.x;
        let lowest = ceil((centre - half_width) * size_um.y);
        let highest = floor((centre + half_width) * size_um.y);
        for (var j = 0; j < MINOR_COUNT; j++) {
            let minor = lowest + f32(j);
            if (minor > highest) {
                break;
            }
            xyz += lobe(select(vec2f(major, minor), vec2f(minor, major), steep), path, range);
        }
    }
#ifdef HALF
    return series_scale() * series_scale() * xyz;
#else
    return xyz;
#endif
}

// What one bin adds while the segment crosses its lobe: |c|² times colour weights and window, over 1/λ.
fn lobe(bin: vec2f, path: vec3f, range: vec2f) -> vec3f {
#ifdef MONOCHROMATIC
    let texel = textureLoad(spectrum, vec2i(0, 0), 0);
    return intensity(bin, path, texel.w) * texel.xyz;
#else
    let span = lobe_span(bin / vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM), path.xy, range);
    if (span.x >= span.y) {
        return vec3f(0.0);
    }
    // a broad lobe is cut into panels: the bin's intensity is taken once in each, where its light is
    let share = (span.y - span.x) / (range.y - range.x) * f32(PANEL_COUNT);
    let panels = select(min(ceil(share), f32(PANEL_COUNT)), 1.0, share < WHOLE_PANELS);
    let pace = (span.y - span.x) / (panels * f32(NODE_COUNT));
    var xyz = vec3f(0.0);
    for (var panel = 0; panel < PANEL_COUNT; panel++) {
        if (f32(panel) >= panels) {
            break;
        }
        var weight = vec3f(0.0);
        var total = 0.0;
        var moment = 0.0;
        for (var node = 0; node < NODE_COUNT; node++) {
            let wavenumber = span.x + (f32(panel * NODE_COUNT + node) + 0.5) * pace;
            let light = window_share(bin, path.xy, wavenumber) * colour_weights(wavenumber, range);
            weight += light;
            total += light.x + light.y + light.z;
            moment += wavenumber * (light.x + light.y + light.z);
        }
        if (total > 0.0) {
            let amplitude = bin_amplitude(vec2i(bin), series_argument(path.z, total / moment));
            xyz += dot(amplitude, amplitude) * weight;
        }
    }
    return pace * xyz;
#endif
}

#ifndef MONOCHROMATIC
// Wavenumbers within reach of a bin, cut to the range.
fn lobe_span(place: vec2f, uv: vec2f, range: vec2f) -> vec2f {
    let half_width = 0.70710678 * REACH_SIGMAS * window_width(1.0 / 0.55);
#ifdef COHERENCE_SCALES
    // the lobe is a Gaussian in λ
    let squared = max(dot(place, place), 1e-12);
    let centre_um = dot(uv, place) / squared;
    let half_um = 0.55 * half_width / sqrt(squared);
    let low_um = max(centre_um - half_um, 1.0 / range.y);
    let high_um = min(centre_um + half_um, 1.0 / range.x);
    return select(vec2f(1.0, 0.0), 1.0 / vec2f(high_um, low_um), low_um < high_um);
#else
    let squared = max(dot(uv, uv), 1e-12);
    let centre = dot(uv, place) / squared;
    let half_span = half_width / sqrt(squared);
    return vec2f(max(centre - half_span, range.x), min(centre + half_span, range.y));
#endif
}

// X, Y, Z per 1/µm at a wavenumber.
fn colour_weights(wavenumber: f32, range: vec2f) -> vec3f {
    let place = (wavenumber - range.x) / (range.y - range.x) * f32(WAVELENGTH_COUNT - 1);
    let index = clamp(i32(place), 0, WAVELENGTH_COUNT - 2);
    let before = textureLoad(spectrum, vec2i(index, 0), 0).xyz;
    let after = textureLoad(spectrum, vec2i(index + 1, 0), 0).xyz;
    return mix(before, after, place - f32(index));
}
#endif

// Share of a bin's intensity that the window lets through at f = uv·t.
fn window_share(bin: vec2f, uv: vec2f, wavenumber: f32) -> f32 {
    let place = wavenumber * uv * vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
    let weight = window(place - bin, window_sharpness(1.0 / wavenumber));
    return weight * weight;
}

// Standard deviation of the window's spectrum, cycles per µm.
fn window_width(wavenumber: f32) -> f32 {
#ifdef COHERENCE_SCALES
    return 0.55 * wavenumber / (6.2831853 * 0.25 * COHERENCE_UM);
#else
    return 1.0 / (6.2831853 * 0.25 * COHERENCE_UM);
#endif
}

// Least and greatest wavenumber.
fn wavenumbers() -> vec2f {
#ifdef MONOCHROMATIC
    return vec2f(1.0 / textureLoad(spectrum, vec2i(0, 0), 0).w);
#else
    return 1.0 / vec2f(WAVELENGTH_MAX_UM, WAVELENGTH_MIN_UM);
#endif
}
