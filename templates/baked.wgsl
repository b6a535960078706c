// Colours from a table over (u, v, w): the wavelengths are integrated beforehand.

// Tristimulus values without gain. Columns: the angle of (u, v), cut into pages that repeat the first column of the next;
// rows: asinh of |(u, v)|; layers: w² over its greatest value, page by page.
@group(0) @binding(1) var colours: texture_2d_array<f32>;
#ifdef ROTATED
// Row 1: cosine and sine of the surface's rotation.
@group(0) @binding(2) var spectrum: texture_2d<f32>;
#endif
#ifdef FILTERED
// Linear between texels, clamped to the edge.
@group(0) @binding(5) var linear_clamp: sampler;
#endif

// What the table's numbers are to be multiplied by: 2⁻¹⁵.
const COLOUR_UNIT: f32 = 0.000030517578125;
// Slope of an octant's places at their beginning.
const BEND: f32 = 1.35;

// Relative tristimulus values for one pair of directions.
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    let factor = gain(wi, wr);
    if (factor == 0.0) {
        return vec3f(0.0);
    }
    return factor * COLOUR_UNIT * colour_between(path_difference(wi, wr));
}

// The table between its levels.
fn colour_between(path: vec3f) -> vec3f {
    let squared = dot(path.xy, path.xy);
    let turn = column_at(path.xy);
    let page = min(floor(turn / f32(PAGE_COLUMNS)), f32(PAGE_COUNT - 1));
    let place = vec2f(turn - page * f32(PAGE_COLUMNS), row_at(squared));
    let share = min(path.z * path.z / max(4.0 - squared, 1e-6), 1.0);
    let level = share * f32(LEVEL_COUNT - 1);
    let below = min(floor(level), f32(LEVEL_COUNT - 2));
    let layer = i32(page) * LEVEL_COUNT + i32(below);
    return mix(texel_at(place, layer), texel_at(place, layer + 1), level - below);
}

// Place along the turn, in columns. In an octant a parabola stands for the arc tangent, and the table is laid out by it.
fn column_at(uv: vec2f) -> f32 {
    let size = abs(uv);
    let tangent = min(size.x, size.y) / max(max(size.x, size.y), 1e-20);
    let octant = tangent * (BEND - (BEND - 1.0) * tangent);
    let quadrant = select(octant, 2.0 - octant, size.y > size.x);
    let upper = select(quadrant, 4.0 - quadrant, uv.x < 0.0);
    return select(upper, 8.0 - upper, uv.y < 0.0) * f32(COLUMN_COUNT / 8);
}

// Place along the radius, in rows, from |(u, v)|².
fn row_at(squared: f32) -> f32 {
    let stretched = STRETCH * STRETCH * squared;
    return min(ROW_PACE * log(sqrt(stretched) + sqrt(stretched + 1.0)), f32(ROW_COUNT - 1));
}

// A layer between texels; whole places are their middles.
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
