//- Twin: src/variant/twin/cells.rs.

// Many orders under surroundings. The colours over (u, v) are divided into cells. Each asks for the radiance once, from the
// direction of its centroid, blurred over its own width.

// Columns: cells. Row 0: u and v of the centroid, then the standard deviation of the cell's light on each axis, in direction
// cosines. Then three rows for each layer of w, for red, green and blue light: X, Y, Z of the cell without the gain.
@group(0) @binding(6) var cells: texture_2d<f32>;

// X, Y, Z of the radiance under the surroundings, relative to a white of radiance 1.
fn tristimulus_environment(wr: vec3f) -> vec3f {
    if (!(wr.z > 1e-6)) {
        return vec3f(0.0);
    }
#ifdef ROTATED
    let turn = textureLoad(spectrum, vec2i(0, 1), 0);
#endif
    var xyz = vec3f(0.0);
    for (var cell = 0; cell < CELL_COUNT; cell++) {
        let place = textureLoad(cells, vec2i(cell, 0), 0);
#ifdef ROTATED
        let plane = -wr.xy - vec2f(turn.x * place.x - turn.y * place.y, turn.x * place.y + turn.y * place.x);
#else
        let plane = -wr.xy - place.xy;
#endif
        let squared = dot(plane, plane);
        if (squared < 0.9999) {
            let wi = vec3f(plane, sqrt(1.0 - squared));
            let light = environment_radiance(wi, place.z * inverseSqrt(wi.z));
            let path = path_difference(wi, wr);
            let layer = layer_share(path.z, dot(path.xy, path.xy)) * f32(CELL_LAYERS - 1);
            let below = min(floor(layer), f32(CELL_LAYERS - 2));
            let first = vec2i(cell, 1 + 3 * i32(below));
            let one = cell_light(first, light);
            let next = cell_light(first + vec2i(0, 3), light);
            xyz += gain(wi, wr) / wi.z * mix(one, next, layer - below);
        }
    }
    return xyz;
}

// X, Y, Z of a cell under light of a colour, on the layer whose rows begin at `first`.
fn cell_light(first: vec2i, light: vec3f) -> vec3f {
    let red = textureLoad(cells, first, 0).xyz;
    let green = textureLoad(cells, first + vec2i(0, 1), 0).xyz;
    let blue = textureLoad(cells, first + vec2i(0, 2), 0).xyz;
    return light.x * red + light.y * green + light.z * blue;
}
