//- Twin: src/variant/twin/nodes.rs.

// The wavelength integral as a sum over fixed wavelengths, the nodes.

// Row 0: weights of X, Y, Z and wavelength in µm of each node. Row 1: cosine and sine of the surface's rotation, scale
// of the first term, ratio of the scales.
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
    var xyz = vec3f(0.0);
    for (var node = 0; node < WAVELENGTH_COUNT; node++) {
        let texel = textureLoad(spectrum, vec2i(node, 0), 0);
#ifdef MATERIAL
        xyz += texel.xyz * response(path, texel.w) * reflectance(texel.w, facing);
#else
        xyz += texel.xyz * response(path, texel.w);
#endif
    }
    return factor * xyz;
}
