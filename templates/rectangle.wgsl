//- Twin: src/variant/twin/rectangle.rs.

// Linear RGB of the radiance under a spherical quadrilateral of radiance 1: a window, a softbox. Its corners are unit
// vectors, in either order around it; two neighbouring ones may be the same. It must be convex and fit into a hemisphere.
fn diffraction_rectangle(a: vec3f, b: vec3f, c: vec3f, d: vec3f, wr: vec3f) -> vec3f {
    return to_rgb(tristimulus_rectangle(a, b, c, d, wr));
}

// The same as tristimulus values X, Y, Z, relative to a white of radiance 1.
fn tristimulus_rectangle(a: vec3f, b: vec3f, c: vec3f, d: vec3f, wr: vec3f) -> vec3f {
    if (!(wr.z > 1e-6)) {
        return vec3f(0.0);
    }
    let viewer = in_surface(wr);
    let middle = normalize(a + b + c + d);
    let turning = cross(a, b) + cross(b, c) + cross(c, d) + cross(d, a);
    let side = select(-1.0, 1.0, dot(turning, middle) > 0.0);
    let axis = in_surface(middle);
    let first = in_surface(edge_normal(a, b, side, middle));
    let second = in_surface(edge_normal(b, c, side, middle));
    let third = in_surface(edge_normal(c, d, side, middle));
    let fourth = in_surface(edge_normal(d, a, side, middle));
    let farther = max(distance(a, middle), distance(b, middle));
    let reach = max(farther, max(distance(c, middle), distance(d, middle)));
    let offset = axis.xy + viewer.xy;
    let rows = order_rows(offset, reach);
    var xyz = vec3f(0.0);
    for (var row = rows.x; row <= rows.y; row++) {
        let columns = order_columns(row, offset, reach);
        for (var column = columns.x; column <= columns.y; column++) {
            xyz += rectangle_order(vec2i(column, row), first, second, third, fourth, viewer);
        }
    }
    return normal_reflectance() * xyz;
}

// Unit vector to the inner side of an edge. For an edge without length, the middle: the hemisphere about it contains all.
fn edge_normal(start: vec3f, end: vec3f, side: f32, middle: vec3f) -> vec3f {
    let normal = side * cross(start, end);
    let squared = dot(normal, normal);
    if (squared < 1e-12) {
        return middle;
    }
    return normal * inverseSqrt(squared);
}

// X, Y, Z of an order under radiance 1 from the intersection of four hemispheres. The order's light may leave and enter
// again, so the wavelengths at which it crosses an edge are taken one after the other, and each range is tested in its
// middle.
fn rectangle_order(
    order: vec2i,
    first: vec3f,
    second: vec3f,
    third: vec3f,
    fourth: vec3f,
    wr: vec3f,
) -> vec3f {
    let frequency = order_frequency(order);
    let range = propagating(frequency, wr);
    let one = crossings(frequency, wr, first, 2.0);
    let two = crossings(frequency, wr, second, 2.0);
    let three = crossings(frequency, wr, third, 2.0);
    let four = crossings(frequency, wr, fourth, 2.0);
    let early = vec4f(one, two);
    let late = vec4f(three, four);
    var xyz = vec3f(0.0);
    var from_um = range.x;
    for (var part = 0; part < 9; part++) {
        if (!(from_um < range.y)) {
            break;
        }
        // the nearest edge beyond
        let ahead = select(range.yyyy, early, early > vec4f(from_um));
        let behind = select(range.yyyy, late, late > vec4f(from_um));
        let nearest = min(ahead, behind);
        let to_um = min(range.y, min(min(nearest.x, nearest.y), min(nearest.z, nearest.w)));
        let wi = arrival(frequency, 0.5 * (from_um + to_um), wr);
        let lit = within(wi, first, 2.0) && within(wi, second, 2.0);
        if (lit && within(wi, third, 2.0) && within(wi, fourth, 2.0)) {
            xyz += order_colour(order, from_um, to_um, wr);
        }
        from_um = to_um;
    }
    return xyz;
}
