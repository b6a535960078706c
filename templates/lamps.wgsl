//- Twin: src/variant/twin/lamps.rs.

// Lamps. The colour of an order is the integral over the wavelengths at which its light comes from within the lamp. A lamp is an intersection of caps, each given by its axis and the square of the
// chord from the axis to its edge; a hemisphere has the square 2.

// Integrals of the colour weights from the shortest wavelength. Columns: equal steps of the wavelength. Rows: X, Y, Z of white
// light, with the weights times the powers 0 to 3 of t = (λ - 0.58 µm)/0.2 µm in the channels; then X, Y, Z between a column
// and the next in the channels of one row. Rows 4 to 7: the same of the red share of white light; rows 8 to 11: of the green.
@group(0) @binding(4) var moments: texture_2d<f32>;

#ifdef DISC
// Square of the chord from the axis of a disc to its edge. A series, since the sine of a driver may be wrong in the fourth
// digit.
fn disc_chord_squared(radius: f32) -> f32 {
    let half = 0.5 * clamp(radius, 1e-4, 1.5707963);
    let squared = half * half;
    let inner = 1.0 - squared / 42.0 * (1.0 - squared / 72.0);
    let sine = half * (1.0 - squared / 6.0 * (1.0 - squared / 20.0 * inner));
    return 4.0 * sine * sine;
}

#endif
#ifdef RECTANGLE
// Unit vector to the inner side of an edge. For an edge without length, the centre: the hemisphere about it contains all.
fn edge_normal(start: vec3f, end: vec3f, side: f32, centre: vec3f) -> vec3f {
    // of a short edge, the difference has digits that the product of the ends would lose
    let normal = side * cross(start, end - start);
    let squared = dot(normal, normal);
    if (squared < 1e-12) {
        return centre;
    }
    return normal * inverseSqrt(squared);
}

#endif
// First and last row of orders that may take light from within `reach` of a direction; `offset` is the sum of the
// direction cosines of light and viewer.
fn order_rows(offset: vec2f, reach: f32) -> vec2i {
    let ends = vec2f(WAVELENGTH_MIN_UM, WAVELENGTH_MAX_UM);
#ifdef PATTERN
    return orders_between(offset.y, reach, ends, pattern.z * PATCH_HEIGHT_UM, ORDER_REACH_Y);
#else
    return orders_between(offset.y, reach, ends, PATCH_HEIGHT_UM, ORDER_REACH_Y);
#endif
}

// The same for the orders of a row.
fn order_columns(row: i32, offset: vec2f, reach: f32) -> vec2i {
    var ends = vec2f(WAVELENGTH_MIN_UM, WAVELENGTH_MAX_UM);
    if (row != 0) {
        // wavelengths at which the row passes the light
#ifdef PATTERN
        let height_um = pattern.z * PATCH_HEIGHT_UM;
        let sides = height_um / f32(row) * (vec2f(-reach, reach) - offset.y);
#else
        let sides = PATCH_HEIGHT_UM / f32(row) * (vec2f(-reach, reach) - offset.y);
#endif
        ends.x = max(ends.x, min(sides.x, sides.y));
        ends.y = min(ends.y, max(sides.x, sides.y));
    }
    if (ends.x > ends.y) {
        return vec2i(0, -1);
    }
#ifdef PATTERN
    return orders_between(offset.x, reach, ends, pattern.z * PATCH_WIDTH_UM, ORDER_REACH_X);
#else
    return orders_between(offset.x, reach, ends, PATCH_WIDTH_UM, ORDER_REACH_X);
#endif
}

// First and last order along one axis that passes within `reach` between two wavelengths.
fn orders_between(offset: f32, reach: f32, ends: vec2f, size_um: f32, limit: i32) -> vec2i {
    let low = size_um * (-offset - reach) / ends;
    let high = size_um * (-offset + reach) / ends;
    let most = f32(limit);
    let first = clamp(ceil(min(low.x, low.y)), -most, most + 1.0);
    let last = clamp(floor(max(high.x, high.y)), -most - 1.0, most);
    return vec2i(i32(first), i32(last));
}

// Wavelengths at which an order's direction crosses the edge of a cap above the horizon; 1e9 where it does not.
fn crossings(frequency: vec2f, wr: vec3f, axis: vec3f, chord_squared: f32) -> vec2f {
    let along = polar(frequency);
    let across = vec2f(-along.y, along.x);
    let start = -vec2f(dot(wr.xy, along.xy), dot(wr.xy, across));
    let lamp = vec2f(dot(axis.xy, along.xy), dot(axis.xy, across));
    // in this form, no small number is a difference of large ones, as it would be with the cosine of a small cap
    let apart = start.y - lamp.y;
    let sine_squared = chord_squared * (1.0 - 0.25 * chord_squared);
    let of_cap = sine_squared - apart * apart - chord_squared * start.y * lamp.y;
    let size_squared = max(lamp.x * lamp.x + axis.z * axis.z, 1e-12);
    let size = sqrt(size_squared);
    // the edge of a polygon along which the order runs
    let of_edge = (size - start.y) * (size + start.y);
    let squared = select(of_cap, of_edge, chord_squared == 2.0);
    if (squared <= 0.0) {
        return vec2f(1e9);
    }
    let root = sqrt(squared) * vec2f(-1.0, 1.0);
    let middle = 1.0 - 0.5 * chord_squared - start.y * lamp.y;
    let places = (lamp.x * middle + axis.z * root) / size_squared;
    let heights = axis.z * middle - lamp.x * root;
    return select(vec2f(1e9), (start.x - places) / along.z, heights > vec2f(0.0));
}

// Whether a direction lies within a cap.
fn within(direction: vec3f, axis: vec3f, chord_squared: f32) -> bool {
    let chord = direction - axis;
    return dot(chord, chord) < chord_squared;
}

// X, Y, Z of an order between two wavelengths under a radiance in linear sRGB, without the reflectance at normal
// incidence. The range is divided where the share of the order changes too much for a cubic.
fn order_colour(order: vec2i, from_um: f32, to_um: f32, colour: vec3f, wr: vec3f) -> vec3f {
    let frequency = order_frequency(order);
    let count = panel_count(frequency, from_um, to_um, wr);
    var xyz = vec3f(0.0);
    var start_um = from_um;
    for (var panel = 1; panel <= count; panel++) {
        var end_um = to_um;
        if (panel < count) {
            end_um = wavelength_between(frequency, from_um, to_um, f32(panel) / f32(count), wr);
        }
        xyz += panel_colour(order, frequency, start_um, end_um, colour, wr);
        start_um = end_um;
    }
    return xyz;
}

// Number of panels between two wavelengths.
fn panel_count(frequency: vec2f, from_um: f32, to_um: f32, wr: vec3f) -> i32 {
    let first = arrival(frequency, from_um, wr);
    let last = arrival(frequency, to_um, wr);
    let middle_um = 0.5 * (from_um + to_um);
    let middle = arrival(frequency, middle_um, wr);
    // the phase changes fastest in the half of the shorter wavelengths
#ifdef COVER
    let turns = 2.0 * abs(depth(first, wr) / from_um - depth(middle, wr) / middle_um);
#else
    let turns = 2.0 * abs((first.z + wr.z) / from_um - (middle.z + wr.z) / middle_um);
#endif
#ifdef PATTERN
    let columns = 0.5 * PHASE_MIN_UM * pattern.w * f32(EFFICIENCY_COLUMNS) * turns;
#else
#ifdef COVER
    let columns = 0.5 * PHASE_MIN_UM * f32(EFFICIENCY_COLUMNS) * turns;
#else
    let columns = 0.5 * WAVELENGTH_MIN_UM * f32(EFFICIENCY_COLUMNS) * turns;
#endif
#endif
#ifdef MATERIAL
    let coloured = PANEL_PACE * abs(1.0 / from_um - 1.0 / to_um);
    let curved = max(distance(first, last) / PANEL_ARC, coloured);
    let needed = max(columns / PANEL_COLUMNS, curved);
#else
    let needed = max(columns / PANEL_COLUMNS, distance(first, last) / PANEL_ARC);
#endif
    return min(i32(needed), PANEL_COUNT - 1) + 1;
}

// A wavelength between two: in equal steps of the angle on the small circle, so that panels are short where light comes
// along the horizon; of the order that mirrors, in equal steps of the phase.
fn wavelength_between(frequency: vec2f, from_um: f32, to_um: f32, part: f32, wr: vec3f) -> f32 {
    let along = polar(frequency);
    if (along.x == 0.0 && along.y == 0.0) {
        return 1.0 / mix(1.0 / from_um, 1.0 / to_um, part);
    }
    let start = -dot(wr.xy, along.xy);
    let across = wr.y * along.x - wr.x * along.y;
    let half = sqrt(max(1e-12, 1.0 - across * across));
    let ends = (start - vec2f(from_um, to_um) * along.z) / half;
    let angles = asin(clamp(ends, vec2f(-1.0), vec2f(1.0)));
    let place = start - half * sin(mix(angles.x, angles.y, part));
    return clamp(place / along.z, from_um, to_um);
}

// X, Y, Z of a panel: the share of the order is a cubic through its values at four nodes of Chebyshev.
fn panel_colour(
    order: vec2i,
    frequency: vec2f,
    from_um: f32,
    to_um: f32,
    colour: vec3f,
    wr: vec3f,
) -> vec3f {
    let middle = 0.5 * (from_um + to_um);
    let half = 0.5 * (to_um - from_um);
    let outer = 0.92387953 * half;
    let inner = 0.38268343 * half;
    let highest = order_share(order, frequency, middle + outer, wr);
    let high = order_share(order, frequency, middle + inner, wr);
    let low = order_share(order, frequency, middle - inner, wr);
    let lowest = order_share(order, frequency, middle - outer, wr);
    // coefficients of Chebyshev's polynomials, then of powers
    let mean = 0.25 * (highest + high + low + lowest);
    let linear = 0.5 * (0.92387953 * (highest - lowest) + 0.38268343 * (high - low));
    let square = 0.35355339 * (highest - high - low + lowest);
    let cube = 0.5 * (0.38268343 * (highest - lowest) - 0.92387953 * (high - low));
    let powers = vec4f(mean - square, linear - 3.0 * cube, 2.0 * square, 4.0 * cube);
    return moments_between(from_um, to_um, powers, colour);
}

// Integral of the colour weights between two wavelengths, times a polynomial in the distance from the middle relative to
// half the range. A moment about the middle is at most the integral itself, and rounding must not make it larger.
fn moments_between(from_um: f32, to_um: f32, powers: vec4f, colour: vec3f) -> vec3f {
    let white = moments_of(0, from_um, to_um);
    var x = colour.z * white[0];
    var y = colour.z * white[1];
    var z = colour.z * white[2];
    // blue is what red and green leave of white, and grey light needs no more than white
    let more = colour.xy - colour.z;
    if (more.x != 0.0 || more.y != 0.0) {
        let red = moments_of(4, from_um, to_um);
        let green = moments_of(8, from_um, to_um);
        x += more.x * red[0] + more.y * green[0];
        y += more.x * red[1] + more.y * green[1];
        z += more.x * red[2] + more.y * green[2];
    }
    let centre = 5.0 * (0.5 * (from_um + to_um) - 0.58);
    let scale = 1.0 / max(2.5 * (to_um - from_um), 1e-9);
    let light = max(vec3f(x.x, y.x, z.x), vec3f(0.0));
    let first = vec3f(x.y, y.y, z.y);
    let second = vec3f(x.z, y.z, z.z);
    let third = vec3f(x.w, y.w, z.w);
    let linear = (first - centre * light) * scale;
    let square = (second - centre * (2.0 * first - centre * light)) * scale * scale;
    let cubic = third - 3.0 * centre * (second - centre * first) - centre * centre * centre * light;
    let cube = cubic * scale * scale * scale;
    return powers.x * light
        + powers.y * clamp(linear, -light, light)
        + powers.z * clamp(square, -light, light)
        + powers.w * clamp(cube, -light, light);
}

// Moments between two wavelengths of one light of the table, whose first row it is. The columns are X, Y, Z and nothing.
fn moments_of(row: i32, from_um: f32, to_um: f32) -> mat4x4f {
    let first_column = moment_column(from_um);
    let last_column = moment_column(to_um);
    let before = column_part(from_um, first_column, row + 3);
    let after = column_part(to_um, last_column, row + 3);
    let from_powers = column_powers(first_column);
    let to_powers = column_powers(last_column);
    return mat4x4f(
        moment(last_column, row) + after.x * to_powers - moment(first_column, row) - before.x * from_powers,
        moment(last_column, row + 1) + after.y * to_powers - moment(first_column, row + 1) - before.y * from_powers,
        moment(last_column, row + 2) + after.z * to_powers - moment(first_column, row + 2) - before.z * from_powers,
        vec4f(0.0),
    );
}

// Place of a wavelength in columns of the table of moments.
fn moment_place(lambda_um: f32) -> f32 {
    let share = (lambda_um - WAVELENGTH_MIN_UM) / (WAVELENGTH_MAX_UM - WAVELENGTH_MIN_UM);
    return share * f32(MOMENT_COLUMNS - 1);
}

// Column of the table of moments at or below a wavelength.
fn moment_column(lambda_um: f32) -> i32 {
    return clamp(i32(moment_place(lambda_um)), 0, MOMENT_COLUMNS - 2);
}

// X, Y, Z from a column to a wavelength before the next one.
fn column_part(lambda_um: f32, column: i32, row: i32) -> vec3f {
    let part = clamp(moment_place(lambda_um) - f32(column), 0.0, 1.0);
    return part * textureLoad(moments, vec2i(column, row), 0).xyz;
}

// Powers 0 to 3 of t in the middle between a column and the next.
fn column_powers(column: i32) -> vec4f {
    let share = (f32(column) + 0.5) / f32(MOMENT_COLUMNS - 1);
    let t = 5.0 * (mix(WAVELENGTH_MIN_UM, WAVELENGTH_MAX_UM, share) - 0.58);
    return vec4f(1.0, t, t * t, t * t * t);
}

// Moments from the shortest wavelength to a column.
fn moment(column: i32, row: i32) -> vec4f {
    return textureLoad(moments, vec2i(column, row), 0);
}
