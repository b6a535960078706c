//- Twin: src/variant/twin/arrivals.rs.

// Where the light of an order comes from. At each wavelength an order takes light from a direction of its own: with the
// direction cosines α of a direction along the surface, αi = -αr - λf, where f is the order's frequency in cycles per µm.
// As λ varies, this direction runs over a small circle of the sphere.

// Direction in the frame of the surface.
fn in_surface(direction: vec3f) -> vec3f {
#ifdef TURNED
    let turn = turn_of_surface();
    let x = turn.x * direction.x + turn.y * direction.y;
    return vec3f(x, turn.x * direction.y - turn.y * direction.x, direction.z);
#else
    return direction;
#endif
}

#ifdef OUTWARD
// Direction in the tangent frame, from one in the frame of the surface.
fn from_surface(direction: vec3f) -> vec3f {
#ifdef TURNED
    let turn = turn_of_surface();
    let x = turn.x * direction.x - turn.y * direction.y;
    return vec3f(x, turn.x * direction.y + turn.y * direction.x, direction.z);
#else
    return direction;
#endif
}

#endif
// Reflectance at normal incidence.
fn normal_reflectance() -> f32 {
#ifdef MATERIAL
    return textureLoad(spectrum, vec2i(0, MATTER_ROW), 0).y;
#else
    let amplitude = (REFRACTIVE_INDEX - 1.0) / (REFRACTIVE_INDEX + 1.0);
    return amplitude * amplitude;
#endif
}

// Frequency of an order, cycles per µm.
fn order_frequency(order: vec2i) -> vec2f {
#ifdef PATTERN
    return vec2f(order) / (pattern.z * vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM));
#else
    return vec2f(order) / vec2f(PATCH_WIDTH_UM, PATCH_HEIGHT_UM);
#endif
}

// Length and direction of a frequency. For the order that mirrors, the direction is zero.
fn polar(frequency: vec2f) -> vec3f {
    let size = max(length(frequency), 1e-9);
    return vec3f(frequency / size, size);
}

// Direction from which an order takes light of a wavelength; z is 0 where there is none.
fn arrival(frequency: vec2f, lambda_um: f32, wr: vec3f) -> vec3f {
    let shift = lambda_um * frequency;
    // 1 minus the square of the plane part, without its rounding errors at grazing angles
    let squared = wr.z * wr.z - dot(shift, 2.0 * wr.xy + shift);
    return vec3f(-wr.xy - shift, sqrt(max(0.0, squared)));
}

// Shortest and longest wavelength at which an order takes light from above the horizon.
fn propagating(frequency: vec2f, wr: vec3f) -> vec2f {
    let along = polar(frequency);
    let start = -dot(wr.xy, along.xy);
    let across = wr.y * along.x - wr.x * along.y;
    let half = sqrt(max(0.0, 1.0 - across * across));
    let low = max(WAVELENGTH_MIN_UM, (start - half) / along.z);
    return vec2f(low, min(WAVELENGTH_MAX_UM, (start + half) / along.z));
}

// Share of the light that an order sends to the viewer, relative to the reflectance at normal incidence.
fn order_share(order: vec2i, frequency: vec2f, lambda_um: f32, wr: vec3f) -> f32 {
    let wi = arrival(frequency, lambda_um, wr);
#ifdef MATERIAL
#ifdef COVER
#ifdef DISPERSION
    let turns = dispersed(depth(wi, wr), lambda_um) / lambda_um;
#else
    let turns = depth(wi, wr) / lambda_um;
#endif
#else
    let turns = -(wi.z + wr.z) / lambda_um;
#endif
    let reflected = reflectance(lambda_um, facing_of(wi, wr));
    return gain(wi, wr) / max(wi.z, 1e-6) * reflected * efficiency(order, turns);
#else
    return gain(wi, wr) / max(wi.z, 1e-6) * efficiency(order, -(wi.z + wr.z) / lambda_um);
#endif
}
