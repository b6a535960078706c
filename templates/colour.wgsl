//- Twin: src/optics/colour.rs.

// From tristimulus values to linear RGB.

// Linear RGB for one pair of directions.
fn diffraction(wi: vec3f, wr: vec3f) -> vec3f {
    return to_rgb(tristimulus(wi, wr));
}

#ifdef SPREAD
// The same with lobes widened by `spread`, a standard deviation in direction cosines: a footprint, a roughness, a light's
// size. Wider lobes are dimmer and keep their energy. Beyond the widest table the result is that of the widest.
fn diffraction_spread(wi: vec3f, wr: vec3f, spread: f32) -> vec3f {
    return to_rgb(tristimulus_spread(wi, wr, spread));
}

#endif
#ifdef DISC
// Linear RGB of the radiance under a disc, a cap of the sphere: a lamp, the sun. `axis` points to its middle, `radius` is
// its angular radius, 1e-4 to π/2 rad. Its irradiance, perpendicular to the axis, is 1; a white diffuser that faces it
// shows 1/π.
fn diffraction_disc(axis: vec3f, radius: f32, wr: vec3f) -> vec3f {
    return to_rgb(tristimulus_disc(axis, radius, wr));
}

#ifdef LAMPS
// The same under a disc of a colour: its irradiance in linear sRGB, nowhere negative. White, vec3f(1.0), is the disc above.
// The result times a colour is something else: an order brings light of few wavelengths, and red light has no blue ones.
fn diffraction_disc_coloured(axis: vec3f, radius: f32, colour: vec3f, wr: vec3f) -> vec3f {
    return to_rgb(tristimulus_disc_coloured(axis, radius, colour, wr));
}

#endif
#endif
#ifdef RECTANGLE
// Linear RGB of the radiance under a spherical quadrilateral of radiance 1: a window, a softbox. Its corners are unit
// vectors, in either order around it; two neighbouring ones may be the same. It must be convex and fit into a hemisphere.
fn diffraction_rectangle(a: vec3f, b: vec3f, c: vec3f, d: vec3f, wr: vec3f) -> vec3f {
    return to_rgb(tristimulus_rectangle(a, b, c, d, wr));
}

// The same under a quadrilateral of a colour: its radiance in linear sRGB, nowhere negative. White is the one above.
fn diffraction_rectangle_coloured(a: vec3f, b: vec3f, c: vec3f, d: vec3f, colour: vec3f, wr: vec3f) -> vec3f {
    return to_rgb(tristimulus_rectangle_coloured(a, b, c, d, colour, wr));
}

#endif
#ifdef ENVIRONMENT
// Linear RGB of the radiance under the surroundings, in the unit of `environment_radiance`.
fn diffraction_environment(wr: vec3f) -> vec3f {
    return to_rgb(tristimulus_environment(wr));
}

#endif
#ifdef PATH
// Linear RGB of the weight of a path. The mean over many paths of weight times light is the radiance.
fn diffraction_weight(wr: vec3f, path: vec4f) -> vec3f {
    return to_rgb(tristimulus_weight(wr, path));
}

#endif
// Linear RGB of X, Y, Z; negative where a colour lies outside the primaries.
fn to_rgb(xyz: vec3f) -> vec3f {
#ifdef COLOUR_THESIS
    // CIE RGB (1931) with the white point D65 applied a second time: only for comparison with published pictures
    //- Both texts print their matrix so.
    return vec3f(
        0.9505 * dot(vec3f(0.41847, -0.15866, -0.082835), xyz),
        dot(vec3f(-0.091169, 0.25243, 0.015708), xyz),
        1.0890 * dot(vec3f(0.00092090, -0.0025498, 0.17860), xyz),
    );
#else
    // sRGB primaries and D65, IEC 61966-2-1
    return vec3f(
        dot(vec3f(3.2406, -1.5372, -0.4986), xyz),
        dot(vec3f(-0.9689, 1.8758, 0.0415), xyz),
        dot(vec3f(0.0557, -0.2040, 1.0570), xyz),
    );
#endif
}
