//- Twin: src/variant/twin/warped.rs.

// The wavelength integral as a sum over nodes. Nodes are close together where the amplitude changes fast along
// f = (u, v)/λ and where there is much light.

// A row of nodes for each level of |(u, v)|: weights of X, Y, Z and wavelength in µm, which is 0 after the last node.
// Row 0 is the lowest level, the others begin at row 2. Row 1: cosine and sine of the surface's rotation, scale of the
// first term, ratio of the scales.
@group(0) @binding(2) var spectrum: texture_2d<f32>;

// Tristimulus values X, Y, Z for one pair of directions, relative to the peak of a mirror at normal incidence.
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    let factor = gain(wi, wr);
    if (factor == 0.0) {
        return vec3f(0.0);
    }
    let path = path_difference(wi, wr);
#ifdef MATERIAL
    let facing = facing_of(wi, wr);
#endif
    let row = node_row(path.xy);
    var xyz = vec3f(0.0);
    for (var node = 0; node < WAVELENGTH_COUNT; node++) {
        let texel = textureLoad(spectrum, vec2i(node, row), 0);
        if (texel.w == 0.0) {
            break;
        }
#ifdef MATERIAL
        xyz += texel.xyz * intensity(path, texel.w) * reflectance(texel.w, facing);
#else
        xyz += texel.xyz * intensity(path, texel.w);
#endif
    }
#ifdef HALF
    return factor * series_scale() * series_scale() * xyz;
#else
    return factor * xyz;
#endif
}

// Row of the nodes for (u, v).
fn node_row(uv: vec2f) -> i32 {
#ifdef MONOCHROMATIC
    return 0;
#else
    let level = min(i32(0.5 * f32(NODE_LEVELS) * length(uv)), NODE_LEVELS - 1);
    return select(level + 1, 0, level == 0);
#endif
}
