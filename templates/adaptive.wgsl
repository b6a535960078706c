// The wavelength integral as a sum over bins: as λ runs over its range, f = (u, v)/λ walks a straight segment, and only
// bins within a few widths of the window's spectrum see it, each over a lobe of wavenumbers. Narrow lobes take their
// colour from a table; broad ones, near the mirror direction, are sums of narrower ones at fixed wavenumbers.
// Wavenumbers 1/λ are in 1/µm, frequencies in cycles per µm.

#ifdef MONOCHROMATIC
// Row 0: X, Y, Z weights and the wavelength in µm; row 1: cosine and sine of the surface's rotation, scale of the first
// term, ratio of the scales.
#else
// X, Y, Z and the wavelength in µm at which a bin counts. Row 0: of the lobe about each node; row 1: cosine and sine of
// the surface's rotation, scale of the first term, ratio of the scales; the other rows: of narrow lobes over their
// width, columns by their middle, rows by their width, from 0 to the broadest; then the same of second halves.
#endif
@group(0) @binding(2) var spectrum: texture_2d<f32>;

// Lobes end at this many standard deviations of the window's spectrum.
const REACH_SIGMAS: f32 = 4.0;
#ifndef MONOCHROMATIC
// The broadest narrow lobe, in distances of the nodes.
const BROADEST: f32 = 4.0;
#endif

// Relative tristimulus values for one pair of directions.
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    let factor = gain(wi, wr);
    if (factor == 0.0) {
        return vec3f(0.0);
    }
    return factor * corridor(path_difference(wi, wr));
}

// The sum over the bins of a strip along the segment: columns one by one and the few rows across, or the other way where
// the segment is steep. Where lobes are broad, over the bins about each node instead.
fn corridor(path: vec3f) -> vec3f {
    let steep = abs(path.y) > abs(path.x);
    let patch_um = vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
    let uv = select(path.xy, path.yx, steep);
    let size_um = select(patch_um, patch_um.yx, steep);
    let range = wavenumbers();
    let reach = REACH_SIGMAS * window_width(range.y);
    let squared = max(dot(uv, uv), 1e-12);
    let slope = uv.y / select(uv.x, 1.0, uv.x == 0.0);
    // bins are apart by this
    let pitch = 1.0 / size_um;
    let ends = uv.x * range;
    let first = ceil((min(ends.x, ends.y) - reach) * size_um.x);
    let last = floor((max(ends.x, ends.y) + reach) * size_um.x);
    let breadth = lobe_breadth(sqrt(squared), range);
    let broad = breadth >= 1.0;
    let count = select(i32(last - first) + 1, NODE_COUNT * NODE_BINS, broad) * MINOR_COUNT;
    let half_width = select(reach * sqrt(1.0 + slope * slope), reach, broad) * size_um.y;
    let slant = slope * pitch.x * size_um.y;
    let pace = select(0.0, node_pace(range), broad);
    let nearness = 1.0 / squared;
#ifndef COHERENCE_SCALES
    let sharpness = lobe_sharpness(window_width(range.x), squared, pace);
#endif
    let row = lobe_row(breadth);
    let halves = lobe_halves(row);
    var xyz = vec3f(0.0);
    var index = 0;
    var node = 0;
    var bin = vec2f(0.0);
    var wavenumber = 0.0;
    var exponent = 0.0;
    var side = halves - 1;
    for (var hit = 0; hit < 2 * CANDIDATE_COUNT; hit++) {
        // when a bin's light is all there, the next one within reach is sought first, so that pixels side by side
        // evaluate theirs together
        side = select(side + 1, 0, side + 1 == halves);
        exponent = select(exponent, REACH_SIGMAS * REACH_SIGMAS, side == 0);
        let candidates = select(0, CANDIDATE_COUNT, side == 0);
        for (var tried = 0; tried < candidates; tried++) {
            if (index >= count) {
                break;
            }
            let line = index / MINOR_COUNT;
            node = line / NODE_BINS;
            let fixed = node_wavenumber(node, range);
            let corner = ceil((fixed * uv.x - reach) * size_um.x) + f32(line - node * NODE_BINS);
            let major = select(first + f32(line), corner, broad);
            let centre = select(slant * major, fixed * uv.y * size_um.y, broad);
            let lowest = ceil(centre - half_width);
            bin = vec2f(major, lowest + f32(index - line * MINOR_COUNT));
            let place = bin * pitch;
            wavenumber = select(lobe_centre(place, uv, nearness), fixed, broad);
#ifdef COHERENCE_SCALES
            let sharpness = lobe_sharpness(window_width(wavenumber), squared, pace);
#endif
            exponent = window_exponent(wavenumber * uv - place, uv, sharpness);
            index++;
            if (exponent < REACH_SIGMAS * REACH_SIGMAS) {
                break;
            }
        }
        if (exponent >= REACH_SIGMAS * REACH_SIGMAS) {
            break;
        }
        let share = window_share(exponent, squared, window_width(wavenumber), pace);
        let light = lobe_light(wavenumber, node, row, side, range);
        let argument = series_argument(path.z, light.w);
        let amplitude = bin_amplitude(vec2i(select(bin, bin.yx, steep)), argument);
        xyz += share * dot(amplitude, amplitude) * light.xyz;
    }
    // narrow lobes are stored over their width
    let scale = select(window_width(1.0) / sqrt(squared), 1.0, broad);
#ifdef HALF
    return scale * series_scale() * series_scale() * xyz;
#else
    return scale * xyz;
#endif
}

// Width of the lobes of a direction over that of the broadest narrow ones.
fn lobe_breadth(length: f32, range: vec2f) -> f32 {
#ifdef MONOCHROMATIC
    return 1.0;
#else
    return window_width(range.x) / (BROADEST * node_pace(range) * length);
#endif
}

// Wavenumber at which the segment passes a bin.
fn lobe_centre(place: vec2f, uv: vec2f, nearness: f32) -> f32 {
#ifdef COHERENCE_SCALES
    // where the distance is least over the window's width
    return dot(place, place) / max(dot(uv, place), 1e-12);
#else
    return dot(uv, place) * nearness;
#endif
}

// Row of narrow lobes of a width; none, below 0, of broad ones.
fn lobe_row(breadth: f32) -> i32 {
#ifdef MONOCHROMATIC
    return -1;
#else
    return select(i32(breadth * f32(LOBE_ROWS - 1) + 0.5), -1, breadth >= 1.0);
#endif
}

// Wavelengths at which a lobe's bin counts: the broader of the narrow ones are two halves.
fn lobe_halves(row: i32) -> i32 {
#ifdef MONOCHROMATIC
    return 1;
#else
    return select(1, 2, 4 * row >= LOBE_ROWS);
#endif
}

// X, Y, Z of a lobe, or of a half, and the wavelength at which its bin counts.
fn lobe_light(wavenumber: f32, node: i32, row: i32, side: i32, range: vec2f) -> vec4f {
#ifdef MONOCHROMATIC
    return textureLoad(spectrum, vec2i(0, 0), 0);
#else
    if (row < 0) {
        return textureLoad(spectrum, vec2i(node, 0), 0);
    }
    let margin = 0.70710678 * REACH_SIGMAS * BROADEST * node_pace(range);
    let low = range.x - margin;
    let high = range.y + margin * window_width(range.y) / window_width(range.x);
    let column = clamp((wavenumber - low) / (high - low), 0.0, 1.0) * f32(LOBE_COLUMNS - 1);
    let line = 2 + row + side * LOBE_ROWS;
    let index = min(i32(column), LOBE_COLUMNS - 2);
    let before = textureLoad(spectrum, vec2i(index, line), 0);
    let after = textureLoad(spectrum, vec2i(index + 1, line), 0);
    return mix(before, after, column - f32(index));
#endif
}

// Distance of the nodes, two of which lie beyond each end of the range.
fn node_pace(range: vec2f) -> f32 {
#ifdef MONOCHROMATIC
    return 0.0;
#else
    return (range.y - range.x) / f32(NODE_COUNT - 5);
#endif
}

// Wavenumber of a node.
fn node_wavenumber(node: i32, range: vec2f) -> f32 {
#ifdef MONOCHROMATIC
    return range.x;
#else
    return range.x + f32(node - 2) * node_pace(range);
#endif
}

// Factors of the exponent: 1/σf², and what is added along the segment where lobes are broad, `pace` above 0. There a
// Gaussian is a sum of narrower ones, those of the nodes, under one that is narrower too.
fn lobe_sharpness(width: f32, squared: f32, pace: f32) -> vec2f {
    let rest = width * width - pace * pace * squared;
    return vec2f(1.0, pace * pace / rest) / (width * width);
}

// Minus the logarithm of the share of a bin's intensity that the window lets through at an offset from f.
fn window_exponent(offset: vec2f, uv: vec2f, sharpness: vec2f) -> f32 {
    let along = dot(offset, uv);
    return sharpness.x * dot(offset, offset) + sharpness.y * along * along;
}

// The share itself.
fn window_share(exponent: f32, squared: f32, width: f32, pace: f32) -> f32 {
    return width * inverseSqrt(width * width - pace * pace * squared) * exp(-exponent);
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
