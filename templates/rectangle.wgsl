//- Twin: src/variant/twin/rectangle.rs.

// Orders under a spherical quadrilateral.

// X, Y, Z of the radiance under a quadrilateral of radiance 1, relative to a white of radiance 1.
fn tristimulus_rectangle(a: vec3f, b: vec3f, c: vec3f, d: vec3f, wr: vec3f) -> vec3f {
    return tristimulus_rectangle_coloured(a, b, c, d, vec3f(1.0), wr);
}

// The same under a quadrilateral whose radiance is a colour in linear sRGB.
fn tristimulus_rectangle_coloured(a: vec3f, b: vec3f, c: vec3f, d: vec3f, colour: vec3f, wr: vec3f) -> vec3f {
    if (!(wr.z > 1e-6)) {
        return vec3f(0.0);
    }
    let viewer = in_surface(wr);
    let centre = normalize(a + b + c + d);
    let turning = cross(a, b) + cross(b, c) + cross(c, d) + cross(d, a);
    let side = select(-1.0, 1.0, dot(turning, centre) > 0.0);
    let axis = in_surface(centre);
    let first = in_surface(edge_normal(a, b, side, centre));
    let second = in_surface(edge_normal(b, c, side, centre));
    let third = in_surface(edge_normal(c, d, side, centre));
    let fourth = in_surface(edge_normal(d, a, side, centre));
    let farther = max(distance(a, centre), distance(b, centre));
    let reach = max(farther, max(distance(c, centre), distance(d, centre)));
    let offset = axis.xy + viewer.xy;
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
    for (var hit = 0; hit < 9 * ORDER_COUNT; hit++) {
        // As for a disc. The order's light may leave and enter again, so the wavelengths at which it crosses an edge are
        // taken one after the other.
        lit = false;
        for (var tried = 0; tried < 10 * ORDER_COUNT; tried++) {
            if (lit || row > rows.y) {
                break;
            }
            order = vec2i(column, row);
            let frequency = order_frequency(order);
            let range = propagating(frequency, viewer);
            let one = crossings(frequency, viewer, first, 2.0);
            let two = crossings(frequency, viewer, second, 2.0);
            let three = crossings(frequency, viewer, third, 2.0);
            let four = crossings(frequency, viewer, fourth, 2.0);
            let early = vec4f(one, two);
            let late = vec4f(three, four);
            from_um = max(range.x, passed_um);
            // the nearest edge beyond
            let ahead = select(vec4f(range.y), early, early > vec4f(from_um));
            let behind = select(vec4f(range.y), late, late > vec4f(from_um));
            let nearest = min(ahead, behind);
            to_um = min(range.y, min(min(nearest.x, nearest.y), min(nearest.z, nearest.w)));
            let middle = arrival(frequency, 0.5 * (from_um + to_um), viewer);
            let is_open = column <= columns.y && from_um < range.y;
            let upper = within(middle, first, 2.0) && within(middle, second, 2.0);
            lit = is_open && upper && within(middle, third, 2.0) && within(middle, fourth, 2.0);
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
    return normal_reflectance() * xyz;
}
