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
// width, columns by their middle, rows by their width, from 0 to the broadest.
#endif
@group(0) @binding(2) var spectrum: texture_2d<f32>;

// Lobes end at this many standard deviations of the window's spectrum.
const REACH_SIGMAS: f32 = 4.0;

// Relative tristimulus values for one pair of directions.
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    let factor = gain(wi, wr);
    if (factor == 0.0) {
        return vec3f(0.0);
    }
    return factor * corridor(path_difference(wi, wr));
}

// The sum over the bins of a strip along the segment: columns one by one and the few rows across, or the other way where
// the segment is steep. Where lobes are broad, the bins about each node instead.
fn corridor(path: vec3f) -> vec3f {
    let steep = abs(path.y) > abs(path.x);
    let patch_um = vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
    let uv = select(path.xy, path.yx, steep);
    let size_um = select(patch_um, patch_um.yx, steep);
    let range = wavenumbers();
    let reach = REACH_SIGMAS * window_width(range.y);
    let squared = max(dot(uv, uv), 1e-12);
    let slope = uv.y / select(uv.x, 1.0, uv.x == 0.0);
    let ends = uv.x * range;
    let first = ceil((min(ends.x, ends.y) - reach) * size_um.x);
    let last = floor((max(ends.x, ends.y) + reach) * size_um.x);
    // the broadest lobe over this one: rows of the table
    let breadth = lobe_breadth(sqrt(squared), range);
    let broad = breadth >= 1.0;
    let count = select(last - first + 1.0, f32(NODE_COUNT * NODE_BINS), broad);
    let half_width = select(reach * sqrt(1.0 + slope * slope), reach, broad);
    var xyz = vec3f(0.0);
    for (var i = 0; i < MAJOR_COUNT; i++) {
        if (f32(i) >= count) {
            break;
        }
        let node = i / NODE_BINS;
        let fixed = node_wavenumber(node, range);
        let corner = ceil((fixed * uv.x - reach) * size_um.x) + f32(i - node * NODE_BINS);
        let major = select(first + f32(i), corner, broad);
        let centre = select(slope * major / size_um.x, fixed * uv.y, broad);
        let lowest = ceil((centre - half_width) * size_um.y);
        let highest = floor((centre + half_width) * size_um.y);
        for (var j = 0; j < MINOR_COUNT; j++) {
            let minor = lowest + f32(j);
            if (minor > highest) {
                break;
            }
            let place = vec2f(major, minor) / size_um;
            let wavenumber = select(lobe_centre(place, uv, squared), fixed, broad);
            let share = window_share(wavenumber * uv - place, uv, wavenumber, broad, range);
            if (share > 0.0) {
                let light = lobe_light(wavenumber, node, breadth, range);
                let bin = select(vec2f(major, minor), vec2f(minor, major), steep);
                let amplitude = bin_amplitude(vec2i(bin), series_argument(path.z, light.w));
                xyz += share * dot(amplitude, amplitude) * light.xyz;
            }
        }
    }
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
    return window_width(range.x) / (1.4142136 * node_pace(range) * length);
#endif
}

// Wavenumber at which the segment passes a bin.
fn lobe_centre(place: vec2f, uv: vec2f, squared: f32) -> f32 {
#ifdef COHERENCE_SCALES
    // where the distance is least over the window's width
    return dot(place, place) / max(dot(uv, place), 1e-12);
#else
    return dot(uv, place) / squared;
#endif
}

// X, Y, Z of a lobe and the wavelength at which its bin counts.
fn lobe_light(wavenumber: f32, node: i32, breadth: f32, range: vec2f) -> vec4f {
#ifdef MONOCHROMATIC
    return textureLoad(spectrum, vec2i(0, 0), 0);
#else
    if (breadth >= 1.0) {
        return textureLoad(spectrum, vec2i(node, 0), 0);
    }
    let margin = 4.0 * node_pace(range);
    let low = range.x - margin;
    let high = range.y + margin * window_width(range.y) / window_width(range.x);
    let column = clamp((wavenumber - low) / (high - low), 0.0, 1.0) * f32(LOBE_COLUMNS - 1);
    let row = 2 + i32(breadth * f32(LOBE_ROWS - 1) + 0.5);
    let index = min(i32(column), LOBE_COLUMNS - 2);
    let before = textureLoad(spectrum, vec2i(index, row), 0);
    let after = textureLoad(spectrum, vec2i(index + 1, row), 0);
    return mix(before, after, column - f32(index));
#endif
}

#ifndef MONOCHROMATIC
// Distance of the nodes, two of them beyond each end of the range.
fn node_pace(range: vec2f) -> f32 {
    return (range.y - range.x) / f32(NODE_COUNT - 5);
}
#endif

// Wavenumber of a node.
fn node_wavenumber(node: i32, range: vec2f) -> f32 {
#ifdef MONOCHROMATIC
    return range.x;
#else
    return range.x + f32(node - 2) * node_pace(range);
#endif
}

// Share of a bin's intensity that the window lets through at an offset from f, where the lobe is broad within the narrower
// one of a node: a Gaussian is a sum of narrower ones, weighted by what it is narrower than.
fn window_share(offset: vec2f, uv: vec2f, wavenumber: f32, broad: bool, range: vec2f) -> f32 {
    let width = window_width(wavenumber);
    let exponent = dot(offset, offset) / (width * width);
#ifdef MONOCHROMATIC
    return select(0.0, exp(-exponent), exponent < REACH_SIGMAS * REACH_SIGMAS);
#else
    let pace = select(0.0, node_pace(range), broad);
    let rest = width * width - pace * pace * dot(uv, uv);
    let along = dot(offset, uv) * pace;
    let whole = exponent + along * along / (rest * width * width);
    return select(0.0, width * inverseSqrt(rest) * exp(-whole), whole < REACH_SIGMAS * REACH_SIGMAS);
#endif
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
