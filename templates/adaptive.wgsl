//- Twin: src/variant/twin/adaptive.rs.

// The wavelength integral as a sum over bins. As λ runs over its range, f = (u, v)/λ moves along a straight segment.
// Only the bins within a few widths of the window's spectrum contribute, each over a lobe of wavenumbers. The colour of
// a narrow lobe comes from a table. A broad lobe, near the mirror direction, is a sum of narrower ones at fixed
// wavenumbers, the nodes. Wavenumbers 1/λ are in 1/µm, frequencies in cycles per µm.

#ifdef MONOCHROMATIC
// Row 0: weights of X, Y, Z and the wavelength in µm. Row 1: cosine and sine of the surface's rotation, scale of the
// first term, ratio of the scales.
#else
// Row 0: X, Y, Z of the lobe about each node and the wavelength in µm at which its bin is evaluated. Row 1: cosine and
// sine of the surface's rotation, scale of the first term, ratio of the scales. From row 2: the same as row 0 for
// narrow lobes, divided by the lobe's width. Columns are equal steps of the lobe's centre, rows equal steps of its
// width, from 0 to the broadest. The same number of rows follows for the second halves of these lobes.
#endif
@group(0) @binding(2) var spectrum: texture_2d<f32>;

// Tristimulus values X, Y, Z for one pair of directions, relative to the peak of a mirror at normal incidence.
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    let factor = gain(wi, wr);
    if (factor == 0.0) {
        return vec3f(0.0);
    }
#ifdef MATERIAL
    return factor * corridor(path_difference(wi, wr), facing_of(wi, wr));
#else
    return factor * corridor(path_difference(wi, wr));
#endif
}

// X, Y, Z without the gain: the sum over the bins of a strip along the segment. The loop goes through the strip column
// by column, with a few bins each, or row by row where the segment is steep. Where lobes are broad, the sum is over the
// bins about each node.
#ifdef MATERIAL
fn corridor(path: vec3f, facing: vec2f) -> vec3f {
#else
fn corridor(path: vec3f) -> vec3f {
#endif
    let steep = abs(path.y) > abs(path.x);
#ifdef PATTERN
    let patch_um = pattern.z * vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
#else
    let patch_um = vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
#endif
    let uv = select(path.xy, path.yx, steep);
    let size_um = select(patch_um, patch_um.yx, steep);
    let range = wavenumbers();
    let reach = REACH_SIGMAS * window_width(range.y);
    let squared = max(dot(uv, uv), 1e-12);
    let slope = uv.y / select(uv.x, 1.0, uv.x == 0.0);
    // distance between bins, cycles per µm
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
        // Each pass first searches for the next bin within reach, then evaluates it, so that neighbouring pixels
        // evaluate their bins at the same time.
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
#ifdef MATERIAL
        let light = lobe_light(wavenumber, node, row, side, range);
        let weight = window_share(exponent, squared, window_width(wavenumber), pace);
        let share = weight * reflectance(light.w, facing);
#else
        let share = window_share(exponent, squared, window_width(wavenumber), pace);
        let light = lobe_light(wavenumber, node, row, side, range);
#endif
#ifdef MODE_ORDERS
#ifdef DISPERSION
        let turns = dispersed(path.z, light.w) / light.w;
        xyz += share * efficiency(vec2i(select(bin, bin.yx, steep)), turns) * light.xyz;
#else
        xyz += share * efficiency(vec2i(select(bin, bin.yx, steep)), path.z / light.w) * light.xyz;
#endif
#else
        let argument = series_argument(path.z, light.w);
        let amplitude = bin_amplitude(vec2i(select(bin, bin.yx, steep)), argument);
        xyz += share * dot(amplitude, amplitude) * light.xyz;
#endif
    }
    // colours of narrow lobes are stored divided by the lobe's width
    let scale = select(window_width(1.0) / sqrt(squared), 1.0, broad);
#ifdef HALF
    return scale * series_scale() * series_scale() * xyz;
#else
    return scale * xyz;
#endif
}

// Width of the lobes of a direction relative to the broadest narrow lobe; lobes of 1 or more are broad.
fn lobe_breadth(length: f32, range: vec2f) -> f32 {
#ifdef MONOCHROMATIC
    return 1.0;
#else
    return window_width(range.x) / (BROADEST * node_pace(range) * length);
#endif
}

// Wavenumber at which the segment passes closest to a bin, 1/µm.
fn lobe_centre(place: vec2f, uv: vec2f, nearness: f32) -> f32 {
#ifdef COHERENCE_SCALES
    // here the distance divided by the window's width is smallest
    return dot(place, place) / max(dot(uv, place), 1e-12);
#else
    return dot(uv, place) * nearness;
#endif
}

// Row of the table for narrow lobes of this width; -1 for broad lobes.
fn lobe_row(breadth: f32) -> i32 {
#ifdef MONOCHROMATIC
    return -1;
#else
    return select(i32(breadth * f32(LOBE_ROWS - 1) + 0.5), -1, breadth >= 1.0);
#endif
}

// Number of wavelengths at which a lobe's bin is evaluated: 2, one for each half, for the broader narrow lobes, else 1.
fn lobe_halves(row: i32) -> i32 {
#ifdef MONOCHROMATIC
    return 1;
#else
    return select(1, 2, 4 * row >= LOBE_ROWS);
#endif
}

// X, Y, Z of a lobe or of one of its halves, and the wavelength in µm at which its bin is evaluated.
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

// Distance between nodes, 1/µm. OUTER_NODES of them lie beyond each end of the range.
fn node_pace(range: vec2f) -> f32 {
#ifdef MONOCHROMATIC
    return 0.0;
#else
    return (range.y - range.x) / f32(NODE_COUNT - 1 - 2 * OUTER_NODES);
#endif
}

// Wavenumber of a node, 1/µm.
fn node_wavenumber(node: i32, range: vec2f) -> f32 {
#ifdef MONOCHROMATIC
    return range.x;
#else
    return range.x + f32(node - OUTER_NODES) * node_pace(range);
#endif
}

// Factors of the exponent, in squared µm: x is 1/σf², y is added along the segment where lobes are broad (`pace` above
// 0). There the window's Gaussian is written as a sum of narrower Gaussians, one for each node.
fn lobe_sharpness(width: f32, squared: f32, pace: f32) -> vec2f {
    let rest = width * width - pace * pace * squared;
    return vec2f(1.0, pace * pace / rest) / (width * width);
}

// Minus the logarithm of the window's weight for a bin's intensity, at an offset from f in cycles per µm.
fn window_exponent(offset: vec2f, uv: vec2f, sharpness: vec2f) -> f32 {
    let along = dot(offset, uv);
    return sharpness.x * dot(offset, offset) + sharpness.y * along * along;
}

// Weight of the window for a bin's intensity, 0 to 1.
fn window_share(exponent: f32, squared: f32, width: f32, pace: f32) -> f32 {
    return width * inverseSqrt(width * width - pace * pace * squared) * exp(-exponent);
}

// Standard deviation of the window's spectrum, cycles per µm. The standard deviation of the window itself is a quarter
// of the coherence length.
fn window_width(wavenumber: f32) -> f32 {
#ifdef COHERENCE_SCALES
    return REFERENCE_UM * wavenumber / (6.2831853 * 0.25 * COHERENCE_UM);
#else
    return 1.0 / (6.2831853 * 0.25 * COHERENCE_UM);
#endif
}

// Smallest and largest wavenumber, 1/µm.
fn wavenumbers() -> vec2f {
#ifdef MONOCHROMATIC
    return vec2f(1.0 / textureLoad(spectrum, vec2i(0, 0), 0).w);
#else
    return 1.0 / vec2f(WAVELENGTH_MAX_UM, WAVELENGTH_MIN_UM);
#endif
}
