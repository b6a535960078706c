//- All comparisons with twins draw this entry point.

// Tristimulus values for listed directions, to compare a driver's results with probe.json.

#ifdef SIZED
// Arguments of a function, in ARGUMENT_ROWS rows for row k of the picture, counted from the top. w of the first chooses the
// function. 0: one direction to the light, then to the viewer. 1: a disc: its axis, then to the viewer, with the radius in
// w. 2: a quadrilateral: a corner, then to the viewer, then the other corners. 3: the surroundings: any vector, then to
// the viewer. 4 and 5: a disc and a quadrilateral of a colour, which is in w of the last three rows. 8: a path of light from
// a sky: its constant radiance, the viewer with the deviation of a lobe in w, the lobe's axis, its radiance, three random
// numbers. 9: as 0, with the spread in w of the viewer. xyz of the others: unit vectors. A pattern is in a sixth row.
#else
// xyz: unit vectors. Row 2k holds the directions to the light, row 2k+1 the directions to the viewer, for row k of the
// picture, counted from the top.
#endif
@group(0) @binding(3) var directions: texture_2d<f32>;

// X, Y, Z of a pixel, alpha 1.
@fragment
fn probe(@location(0) place: vec2f) -> @location(0) vec4f {
    let pixel = pixel_of(place);
    let column = i32(pixel.x);
    let row = i32(params.size.y - 1.0 - pixel.y);
#ifdef SIZED
#ifdef PATTERN
    let pattern = textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row + 5), 0);
#endif
    let first = textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row), 0);
    let viewer = textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row + 1), 0);
#ifdef DISC
    if (first.w == 1.0) {
        return vec4f(tristimulus_disc(first.xyz, viewer.w, viewer.xyz), 1.0);
    }
#ifdef LAMPS
    if (first.w == 4.0) {
        let colour = probe_colour(column, row);
        return vec4f(tristimulus_disc_coloured(first.xyz, viewer.w, colour, viewer.xyz), 1.0);
    }
#endif
#endif
#ifdef RECTANGLE
    if (first.w == 2.0 || first.w == 5.0) {
        let second = textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row + 2), 0).xyz;
        let third = textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row + 3), 0).xyz;
        let fourth = textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row + 4), 0).xyz;
        if (first.w == 2.0) {
            return vec4f(tristimulus_rectangle(first.xyz, second, third, fourth, viewer.xyz), 1.0);
        }
        let colour = probe_colour(column, row);
        let xyz = tristimulus_rectangle_coloured(first.xyz, second, third, fourth, colour, viewer.xyz);
        return vec4f(xyz, 1.0);
    }
#endif
#ifdef PATH
    if (first.w == 8.0) {
        let axis = textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row + 2), 0).xyz;
        let radiance = textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row + 3), 0).xyz;
        let random = textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row + 4), 0).xyz;
        let path = diffraction_path(viewer.xyz, random);
        let away = 0.5 * dot(path.xyz - axis, path.xyz - axis);
        let light = first.xyz + exp(-away / (viewer.w * viewer.w)) * radiance;
#ifdef MODE_ORDERS
        let part = diffraction_light(light, path.w);
#else
        let part = (light.x + light.y + light.z) / 3.0;
#endif
        return vec4f(part * tristimulus_weight(viewer.xyz, path), 1.0);
    }
#endif
#ifdef ENVIRONMENT
    if (first.w == 3.0) {
        return vec4f(tristimulus_environment(viewer.xyz), 1.0);
    }
#endif
#ifdef SPREAD
    if (first.w == 9.0) {
        return vec4f(tristimulus_spread(first.xyz, viewer.xyz, viewer.w), 1.0);
    }
#endif
    return vec4f(tristimulus(first.xyz, viewer.xyz), 1.0);
#else
    let wi = textureLoad(directions, vec2i(column, 2 * row), 0).xyz;
    let wr = textureLoad(directions, vec2i(column, 2 * row + 1), 0).xyz;
    return vec4f(tristimulus(wi, wr), 1.0);
#endif
}
#ifdef LAMPS

// Colour of the lamp of a call.
fn probe_colour(column: i32, row: i32) -> vec3f {
    return vec3f(
        textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row + 2), 0).w,
        textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row + 3), 0).w,
        textureLoad(directions, vec2i(column, ARGUMENT_ROWS * row + 4), 0).w,
    );
}
#endif
