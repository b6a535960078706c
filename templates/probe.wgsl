//- All comparisons with twins draw this entry point.

// Tristimulus values for listed directions, to compare a driver's results with probe.json.

// xyz: unit vectors. Row 2k holds the directions to the light, row 2k+1 the directions to the viewer, for row k of the
// picture, counted from the top.
@group(0) @binding(3) var directions: texture_2d<f32>;

// X, Y, Z of a pixel, alpha 1.
@fragment
fn probe(@location(0) place: vec2f) -> @location(0) vec4f {
    let pixel = pixel_of(place);
    let column = i32(pixel.x);
    let row = i32(params.size.y - 1.0 - pixel.y);
    let wi = textureLoad(directions, vec2i(column, 2 * row), 0).xyz;
    let wr = textureLoad(directions, vec2i(column, 2 * row + 1), 0).xyz;
    return vec4f(tristimulus(wi, wr), 1.0);
}
