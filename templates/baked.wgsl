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
#ifdef COVER
    let above = path.z * path.z - LEAST_W_SQUARED;
    let share = clamp(above / max(4.0 - squared, 1e-6), 0.0, 1.0);
#else
#ifdef EVEN_LEVELS
    let share = min(-path.z * inverseSqrt(max(4.0 - squared, 1e-6)), 1.0);
#else
    let share = min(path.z * path.z / max(4.0 - squared, 1e-6), 1.0);
#endif
#endif
    let level = share * f32(LEVEL_COUNT - 1);
    let below = min(floor(level), f32(LEVEL_COUNT - 2));
    let layer = i32(page) * LEVEL_COUNT + i32(below);
    return mix(texel_at(place, layer), texel_at(place, layer + 1), level - below);
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
// X, Y, Z of the radiance under a disc of irradiance 1, relative to a white of radiance 1: the sum of lobes that stand in
// its middle and on a ring. A disc that is hardly wider than the narrowest lobes is one lobe of the same variance.
fn tristimulus_disc(axis: vec3f, radius: f32, wr: vec3f) -> vec3f {
    let sine = sin(radius);
    let disc = 0.25 * sine * sine;
    let is_wide = disc > NARROW_DISC * LOBE_SIGMA * LOBE_SIGMA;
    let count = select(1, DISC_LOBES, is_wide);
    let variance = select(disc, DISC_SHARE * disc, is_wide);
    // two directions across the axis
    let other = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(axis.x) > 0.7);
    let across = normalize(cross(axis, other));
    let along = cross(axis, across);
    let away = DISC_RING * radius;
    var xyz = vec3f(0.0);
    for (var lobe = 0; lobe < count; lobe++) {
        let turn = 6.2831853 / f32(DISC_LOBES - 1) * f32(lobe);
        let on_ring = cos(away) * axis + sin(away) * (cos(turn) * across + sin(turn) * along);
        let wi = select(on_ring, axis, lobe == 0);
        // in direction cosines a lobe is as wide as its cosine allows
        xyz += tristimulus_spread(wi, wr, sqrt(variance * max(wi.z, 0.0)));
    }
    let normal = textureLoad(spectrum, vec2i(SPREAD_LEVELS, 0), 0).x;
    // solid angle of the disc times its radiance
    let light = 2.0 / (1.0 + cos(radius));
    return light * normal / (6.2831853 * LOBE_SIGMA * LOBE_SIGMA * f32(count)) * xyz;
}

#endif
// X, Y, Z without the gain and in units of COLOUR_UNIT, of lobes whose variance is `variance` times that of the narrowest
// ones, up to the widest: between the two nearest levels. Wider lobes are dimmer by the same factor, which keeps energy.
fn colour_widened(path: vec3f, variance: f32) -> vec3f {
    let wanted = clamp(variance, 1.0, WIDEST_VARIANCE);
    var level = 0;
    var own = 1.0;
    for (var next = 1; next < SPREAD_LEVELS; next++) {
        if (wanted >= own * LEVEL_RATIO) {
            own *= LEVEL_RATIO;
            level = next;
        }
    }
    var narrower = vec3f(0.0);
    if (level == 0) {
        narrower = colour_between(path);
    } else {
        narrower = wide_between(path, level);
    }
    let wider = wide_between(path, level + 1) / LEVEL_RATIO;
    return mix(narrower, wider, wider_share(wanted / own)) / own;
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
    let layer = layer_at(path.z, squared);
    let below = min(floor(layer), f32(WIDE_LAYERS - 2));
    let part = place - first;
    return mix(wide_texel_at(corner, part, i32(below)), wide_texel_at(corner, part, i32(below) + 1), layer - below);
}

// Position on the layers of `wide`.
fn layer_at(w: f32, squared: f32) -> f32 {
#ifdef COVER
    let above = w * w - LEAST_W_SQUARED;
    let share = clamp(above / max(4.0 - squared, 1e-6), 0.0, 1.0);
#else
#ifdef EVEN_LEVELS
    let share = min(-w * inverseSqrt(max(4.0 - squared, 1e-6)), 1.0);
#else
    let share = min(w * w / max(4.0 - squared, 1e-6), 1.0);
#endif
#endif
    return share * f32(WIDE_LAYERS - 1);
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
