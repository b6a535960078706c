//- Twin: src/variant/twin/disc.rs.

// Orders under a disc.

// X, Y, Z of the radiance under a disc of irradiance 1, relative to a white of radiance 1.
fn tristimulus_disc(axis: vec3f, radius: f32, wr: vec3f) -> vec3f {
    return tristimulus_disc_coloured(axis, radius, vec3f(1.0), wr);
}

// The same under a disc whose irradiance is a colour in linear sRGB.
fn tristimulus_disc_coloured(axis: vec3f, radius: f32, colour: vec3f, wr: vec3f) -> vec3f {
    if (!(wr.z > 1e-6)) {
        return vec3f(0.0);
    }
    let viewer = in_surface(wr);
    let lamp = in_surface(axis);
    let chord_squared = disc_chord_squared(radius);
    let reach = sqrt(chord_squared);
    let offset = lamp.xy + viewer.xy;
    let rows = order_rows(offset, reach);
    var row = rows.x;
    var columns = order_columns(row, offset, reach);
    var column = columns.x;
    var order = vec2i(0, 0);
    var from_um = 0.0;
    var to_um = 0.0;
    var passed_um = 0.0;
    var lit = false;
    var xyz = vec3f(0.0);
    for (var hit = 0; hit < 3 * ORDER_COUNT; hit++) {
        // Each pass first searches for the next order and range of wavelengths that are lit, then integrates it, so that
        // neighbouring pixels integrate at the same time. Between the wavelengths at which the order's light crosses the
        // edge it is inside or outside, which is tested in the middle.
        lit = false;
        for (var tried = 0; tried < 4 * ORDER_COUNT; tried++) {
            if (lit || row > rows.y) {
                break;
            }
            order = vec2i(column, row);
            let frequency = order_frequency(order);
            let range = propagating(frequency, viewer);
            let edges = crossings(frequency, viewer, lamp, chord_squared);
            from_um = max(range.x, passed_um);
            // the nearest edge beyond
            let beyond = select(range.yy, edges, edges > vec2f(from_um));
            to_um = min(range.y, min(beyond.x, beyond.y));
            let middle = arrival(frequency, 0.5 * (from_um + to_um), viewer);
            let is_open = column <= columns.y && from_um < range.y;
            lit = is_open && within(middle, lamp, chord_squared);
            if (!is_open || to_um >= range.y) {
                column++;
                if (column > columns.y) {
                    row++;
                    columns = order_columns(row, offset, reach);
                    column = columns.x;
                }
                passed_um = 0.0;
            } else {
                passed_um = to_um;
            }
        }
        if (!lit) {
            break;
        }
        xyz += order_colour(order, from_um, to_um, colour, viewer);
    }
    let sine_squared = chord_squared * (1.0 - 0.25 * chord_squared);
    return normal_reflectance() / (3.1415927 * sine_squared) * xyz;
}
