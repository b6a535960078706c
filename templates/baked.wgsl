//- Twin: src/variant/twin/baked.rs.

// Colours from a table over the path difference (u, v, w). The integral over wavelengths is in the table.

#ifdef MATERIAL
// X, Y, Z with the reflectance of the material and without the gain, divided by COLOUR_UNIT. Columns: angle of (u, v),
// divided into pages; each page ends with the first column of the next. Rows: asinh of |(u, v)|. Layers: w² between its
// least and its greatest, or w without a cover, page after page.
#else
// X, Y, Z without the gain, divided by COLOUR_UNIT. Columns: angle of (u, v), divided into pages; each page ends with
// the first column of the next. Rows: asinh of |(u, v)|. Layers: w² relative to its maximum, page after page.
#endif
@group(0) @binding(1) var colours: texture_2d_array<f32>;
#ifdef SPREAD
// The same with wider lobes, level after level. Each level is a rectangle of the texture, and its pages stand below one
// another. The narrowest lobes are in `colours`, level 0. Lobes have the peak 1 on all levels.
@group(0) @binding(4) var wide: texture_2d_array<f32>;
// Row 0: a texel for each level of `wide`: its first column + PACKED times the rows of a page; its first row; columns of a
// page + PACKED times the number of pages; its stretch. Behind them a texel with the reflectance at normal incidence in
// x. Row 1: cosine and sine of the surface's rotation.
@group(0) @binding(2) var spectrum: texture_2d<f32>;
#else
#ifdef ROTATED
// Row 1: cosine and sine of the surface's rotation.
@group(0) @binding(2) var spectrum: texture_2d<f32>;
#endif
#endif
#ifdef FILTERED
// Linear filter, clamped to the edge.
@group(0) @binding(5) var linear_clamp: sampler;
#endif

// Tristimulus values X, Y, Z for one pair of directions, relative to the peak of a mirror at normal incidence.
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    let factor = gain(wi, wr);
    if (factor == 0.0) {
        return vec3f(0.0);
    }
    return factor * COLOUR_UNIT * colour_between(path_difference(wi, wr));
}

// X, Y, Z without the gain and in units of COLOUR_UNIT, interpolated between the two nearest levels of w².
fn colour_between(path: vec3f) -> vec3f {
    let squared = dot(path.xy, path.xy);
    let turn = column_at(path.xy);
    let page = min(floor(turn / f32(PAGE_COLUMNS)), f32(PAGE_COUNT - 1));
    let place = vec2f(turn - page * f32(PAGE_COLUMNS), row_at(squared));
    let level = layer_share(path.z, squared) * f32(LEVEL_COUNT - 1);
    let below = min(floor(level), f32(LEVEL_COUNT - 2));
    let layer = i32(page) * LEVEL_COUNT + i32(below);
    return mix(texel_at(place, layer), texel_at(place, layer + 1), level - below);
}

// Position between the first and the last layer of w, 0 to 1.
fn layer_share(w: f32, squared: f32) -> f32 {
#ifdef COVER
    let above = w * w - LEAST_W_SQUARED;
    return clamp(above / max(4.0 - squared, 1e-6), 0.0, 1.0);
#else
#ifdef EVEN_LEVELS
    return min(-w * inverseSqrt(max(4.0 - squared, 1e-6)), 1.0);
#else
    return min(w * w / max(4.0 - squared, 1e-6), 1.0);
#endif
#endif
}

// Column of the angle of (u, v), from 0 to COLUMN_COUNT. A parabola replaces the arc tangent in each octant. The table
// is laid out by the same parabola.
fn column_at(uv: vec2f) -> f32 {
    let size = abs(uv);
    let tangent = min(size.x, size.y) / max(max(size.x, size.y), 1e-20);
    let octant = tangent * (BEND - (BEND - 1.0) * tangent);
    let quadrant = select(octant, 2.0 - octant, size.y > size.x);
    let upper = select(quadrant, 4.0 - quadrant, uv.x < 0.0);
    return select(upper, 8.0 - upper, uv.y < 0.0) * f32(COLUMN_COUNT / 8);
}

// Row of a squared radius u² + v², 0 to 4.
fn row_at(squared: f32) -> f32 {
    let stretched = STRETCH * STRETCH * squared;
    return min(ROW_PACE * log(sqrt(stretched) + sqrt(stretched + 1.0)), f32(ROW_COUNT - 1));
}

// X, Y, Z of a layer, bilinear between texels; whole numbers are the centres of texels.
fn texel_at(place: vec2f, layer: i32) -> vec3f {
#ifdef FILTERED
    let size = vec2f(f32(PAGE_COLUMNS + 1), f32(ROW_COUNT));
    return textureSampleLevel(colours, linear_clamp, (place + 0.5) / size, layer, 0.0).xyz;
#else
    let last = vec2f(f32(PAGE_COLUMNS - 1), f32(ROW_COUNT - 2));
    let first = min(floor(place), last);
    let part = place - first;
    let texel = vec2i(first);
    let inner_before = textureLoad(colours, texel, layer, 0).xyz;
    let inner_after = textureLoad(colours, texel + vec2i(1, 0), layer, 0).xyz;
    let outer_before = textureLoad(colours, texel + vec2i(0, 1), layer, 0).xyz;
    let outer_after = textureLoad(colours, texel + vec2i(1, 1), layer, 0).xyz;
    return mix(mix(inner_before, inner_after, part.x), mix(outer_before, outer_after, part.x), part.y);
#endif
}

#ifdef SPREAD
// As `tristimulus`, with lobes widened by `spread`, a standard deviation in direction cosines. Widths add in variance.
fn tristimulus_spread(wi: vec3f, wr: vec3f, spread: f32) -> vec3f {
    let factor = gain(wi, wr);
    if (factor == 0.0) {
        return vec3f(0.0);
    }
    let variance = 1.0 + spread * spread / (LOBE_SIGMA * LOBE_SIGMA);
    return factor * COLOUR_UNIT * colour_widened(path_difference(wi, wr), variance);
}

#ifdef DISC
// X, Y, Z of the radiance under a disc of irradiance 1, relative to a white of radiance 1: the sum of lobes that stand on
// two rings, and the mirror image with its edge in place of theirs. Together they are as wide as the disc, so a disc that is
// no wider than the narrowest lobes is one of these.
fn tristimulus_disc(axis: vec3f, radius: f32, wr: vec3f) -> vec3f {
    if (!(wr.z > 1e-6)) {
        return vec3f(0.0);
    }
    let narrowest = LOBE_SIGMA * LOBE_SIGMA;
    let sine = sin(radius);
    let disc = 0.25 * sine * sine;
    // in direction cosines a disc is as wide as its cosine allows
    let own = disc * max(axis.z, 0.01);
    let is_narrow = own <= narrowest;
    let count = select(DISC_LOBES, 1, is_narrow);
    // the rings add the width that the lobes lack
    let rest = max(own - max(DISC_SHARE * own, narrowest), 0.0);
    let size = radius * sqrt(rest / (DISC_RING_VARIANCE * own));
    // two directions across the axis
    let other = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(axis.x) > 0.7);
    let across = normalize(cross(axis, other));
    let along = cross(axis, across);
    // the order that mirrors is the narrowest lobe in the middle of the table
    let mirror = vec3f(-wr.xy, wr.z);
    let image = COLOUR_UNIT * colour_between(path_difference(mirror, wr)) * select(1.0, 0.0, is_narrow);
    var xyz = gain(mirror, wr) * disc_share(axis, radius, mirror) * image;
    for (var index = 0; index < count; index++) {
        let lobe = select(disc_lobe(index), vec3f(0.0, 0.0, 1.0), is_narrow);
        let away = lobe.x * size;
        let wi = cos(away) * axis + sin(away) * (cos(lobe.y) * across + sin(lobe.y) * along);
        let spread = sqrt(max(DISC_SHARE * disc * wi.z - narrowest, 0.0));
        let blurred = gain(wi, wr) * lobe_at(wi.xy + wr.xy, spread) * image;
        xyz += lobe.z * (tristimulus_spread(wi, wr, spread) - blurred);
    }
    xyz = max(xyz, vec3f(0.0));
    let normal = textureLoad(spectrum, vec2i(SPREAD_LEVELS, 0), 0).x;
    // solid angle of the disc times its radiance
    let light = 2.0 / (1.0 + cos(radius));
    return light * normal / (6.2831853 * narrowest) * xyz;
}

// Mean over a disc of the narrowest lobe with the peak 1 about a direction, as if it were narrower: with a sharp edge.
fn disc_share(axis: vec3f, radius: f32, direction: vec3f) -> f32 {
    // the arc cosine is inexact for small angles
    let beyond = atan2(length(cross(axis, direction)), dot(direction, axis)) - radius;
    // some drivers give no number for a large tanh
    let edge = clamp(6.0 / LOBE_SIGMA * beyond * sqrt(direction.z), -9.0, 9.0);
    let inside = 0.5 - 0.5 * tanh(edge);
    let sine = sin(radius);
    let size = 0.5 * sine * sine * direction.z / (LOBE_SIGMA * LOBE_SIGMA);
    return inside * (1.0 - exp(-size)) / max(size, 1e-6);
}

// A lobe with the peak 1 that is widened by `spread`, at a distance in direction cosines; between two levels, as colours.
fn lobe_at(distance: vec2f, spread: f32) -> f32 {
    let narrowest = LOBE_SIGMA * LOBE_SIGMA;
    let wanted = min(1.0 + spread * spread / narrowest, WIDEST_VARIANCE);
    let own = level_below(wanted).y;
    let squared = 0.5 * dot(distance, distance) / (narrowest * own);
    let wider = exp(-squared / LEVEL_RATIO) / LEVEL_RATIO;
    return mix(exp(-squared), wider, wider_share(wanted / own)) / own;
}

// A lobe of a disc: its distance from the middle relative to the radius of the disc, its angle around it, its share.
fn disc_lobe(index: i32) -> vec3f {
    let is_inner = index < DISC_INNER;
    let count = f32(select(DISC_LOBES - DISC_INNER, DISC_INNER, is_inner));
    let first = f32(select(DISC_INNER, 0, is_inner));
    let share = select(1.0 - DISC_INNER_SHARE, DISC_INNER_SHARE, is_inner);
    let ring = select(DISC_OUTER_RING, DISC_INNER_RING, is_inner);
    return vec3f(ring, 6.2831853 / count * (f32(index) - first), share / count);
}

#endif
// X, Y, Z without the gain and in units of COLOUR_UNIT, of lobes whose variance is `variance` times that of the narrowest
// ones, up to the widest: between the two nearest levels. Wider lobes are dimmer by the same factor, which keeps energy.
fn colour_widened(path: vec3f, variance: f32) -> vec3f {
    let wanted = clamp(variance, 1.0, WIDEST_VARIANCE);
    let below = level_below(wanted);
    let own = below.y;
    let level = i32(below.x);
    var narrower = vec3f(0.0);
    if (level == 0) {
        narrower = colour_between(path);
    } else {
        narrower = wide_between(path, level);
    }
    let wider = wide_between(path, level + 1) / LEVEL_RATIO;
    return mix(narrower, wider, wider_share(wanted / own)) / own;
}

// The widest level, except the last, whose lobes are no wider than `wanted`, and their variance.
fn level_below(wanted: f32) -> vec2f {
    var below = vec2f(0.0, 1.0);
    for (var next = 1; next < SPREAD_LEVELS; next++) {
        if (wanted >= below.y * LEVEL_RATIO) {
            below = vec2f(f32(next), below.y * LEVEL_RATIO);
        }
    }
    return below;
}

// Share of the wider of two levels, 0 to 1. `variance`: the wanted one divided by that of the narrower level.
fn wider_share(variance: f32) -> f32 {
    return (variance - 1.0) / (LEVEL_RATIO - 1.0);
}

// The same as `colour_between` on a level of `wide`, counted from 1.
fn wide_between(path: vec3f, level: i32) -> vec3f {
    let sizes = textureLoad(spectrum, vec2i(level - 1, 0), 0);
    let rows = floor(sizes.x / PACKED);
    let pages = floor(sizes.z / PACKED);
    let columns = sizes.z - PACKED * pages;
    let squared = dot(path.xy, path.xy);
    let turn = column_at(path.xy) * (columns * pages / f32(COLUMN_COUNT));
    let page = min(floor(turn / columns), pages - 1.0);
    let stretched = sizes.w * sizes.w * squared;
    let row = min(WIDE_PACE * log(sqrt(stretched) + sqrt(stretched + 1.0)), rows - 1.0);
    let place = vec2f(turn - page * columns, row);
    let first = min(floor(place), vec2f(columns - 1.0, rows - 2.0));
    let corner = first + vec2f(sizes.x - PACKED * rows, sizes.y + page * rows);
    let layer = layer_share(path.z, squared) * f32(WIDE_LAYERS - 1);
    let below = min(floor(layer), f32(WIDE_LAYERS - 2));
    let part = place - first;
    return mix(wide_texel_at(corner, part, i32(below)), wide_texel_at(corner, part, i32(below) + 1), layer - below);
}

// X, Y, Z of a layer of `wide`, bilinear between the texel at `first` and the next ones.
fn wide_texel_at(first: vec2f, part: vec2f, layer: i32) -> vec3f {
#ifdef FILTERED
    let size = vec2f(f32(WIDE_COLUMNS), f32(WIDE_ROWS));
    return textureSampleLevel(wide, linear_clamp, (first + part + 0.5) / size, layer, 0.0).xyz;
#else
    let texel = vec2i(first);
    let inner_before = textureLoad(wide, texel, layer, 0).xyz;
    let inner_after = textureLoad(wide, texel + vec2i(1, 0), layer, 0).xyz;
    let outer_before = textureLoad(wide, texel + vec2i(0, 1), layer, 0).xyz;
    let outer_after = textureLoad(wide, texel + vec2i(1, 1), layer, 0).xyz;
    return mix(mix(inner_before, inner_after, part.x), mix(outer_before, outer_after, part.x), part.y);
#endif
}
#endif
