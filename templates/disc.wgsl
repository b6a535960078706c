//- Twin: src/variant/twin/disc.rs.

// Linear RGB of the radiance under a disc, a cap of the sphere: a lamp, the sun. `axis` points to its middle, `radius` is
// its angular radius, 1e-4 to π/2 rad. Its irradiance, perpendicular to the axis, is 1; a white diffuser that faces it
// shows 1/π.
fn diffraction_disc(axis: vec3f, radius: f32, wr: vec3f) -> vec3f {
    return to_rgb(tristimulus_disc(axis, radius, wr));
}

// The same as tristimulus values X, Y, Z, relative to a white of radiance 1.
fn tristimulus_disc(axis: vec3f, radius: f32, wr: vec3f) -> vec3f {
    if (!(wr.z > 1e-6)) {
        return vec3f(0.0);
    }
    let viewer = in_surface(wr);
    let lamp = in_surface(axis);
    // a series, since the sine of a driver may be wrong in the fourth digit
    let half = 0.5 * clamp(radius, 1e-4, 1.5707963);
    let squared = half * half;
    let sine = half * (1.0 - squared / 6.0 * (1.0 - squared / 20.0 * (1.0 - squared / 42.0 * (1.0 - squared / 72.0))));
    let chord_squared = 4.0 * sine * sine;
    let reach = 2.0 * sine;
    let offset = lamp.xy + viewer.xy;
    let rows = order_rows(offset, reach);
    var xyz = vec3f(0.0);
    for (var row = rows.x; row <= rows.y; row++) {
        let columns = order_columns(row, offset, reach);
        for (var column = columns.x; column <= columns.y; column++) {
            xyz += disc_order(vec2i(column, row), lamp, chord_squared, viewer);
        }
    }
    let sine_squared = chord_squared * (1.0 - 0.25 * chord_squared);
    return normal_reflectance() / (3.1415927 * sine_squared) * xyz;
}

// X, Y, Z of an order under a disc of radiance 1. Between the wavelengths at which the order's light crosses the edge it
// is inside or outside, which is tested in the middle.
fn disc_order(order: vec2i, axis: vec3f, chord_squared: f32, wr: vec3f) -> vec3f {
    let frequency = order_frequency(order);
    let range = propagating(frequency, wr);
    let edges = crossings(frequency, wr, axis, chord_squared);
    var xyz = vec3f(0.0);
    var from_um = range.x;
    for (var part = 0; part < 3; part++) {
        if (!(from_um < range.y)) {
            break;
        }
        // the nearest edge beyond
        let beyond = select(range.yy, edges, edges > vec2f(from_um));
        let to_um = min(range.y, min(beyond.x, beyond.y));
        if (within(arrival(frequency, 0.5 * (from_um + to_um), wr), axis, chord_squared)) {
            xyz += order_colour(order, from_um, to_um, wr);
        }
        from_um = to_um;
    }
    return xyz;
}
