//- Twin: src/optics/gain.rs, and src/optics/directions.rs for `path_difference`.

// The gain, the factor in front of the interference term (Stam 1999, eqs. 7 and 11), with Schlick's reflectance and the
// shadowing of V-cavities.

// Reflectance relative to normal incidence, 1 to 1/R0, from the cosine between half vector and viewer (Schlick 1994,
// eq. 15).
fn fresnel_ratio(cos_half: f32) -> f32 {
    let amplitude = (REFRACTIVE_INDEX - 1.0) / (REFRACTIVE_INDEX + 1.0);
    let one_minus = 1.0 - cos_half;
    let squared = one_minus * one_minus;
    return 1.0 + (1.0 / (amplitude * amplitude) - 1.0) * squared * squared * one_minus;
}

#ifdef SHADOWING
// Shadowing and masking of V-cavities, 0 to 1 (Torrance and Sparrow 1967).
fn shadowing(wi: vec3f, wr: vec3f) -> f32 {
    let half_vector = normalize(wi + wr);
    return min(1.0, 2.0 * half_vector.z * min(wi.z, wr.z) / dot(half_vector, wr));
}
#endif

// The gain R/R0 · (1 + wi·wr)² / (w² cos θr) · S with the reflectance R/R0 and the shadowing S. It is zero where a
// direction is at or below the horizon; a millionth above it counts as at it, since a cosine is rounded that much.
fn gain(wi: vec3f, wr: vec3f) -> f32 {
    if (!(wi.z > 1e-6 && wr.z > 1e-6)) {
        return 0.0;
    }
    let half_vector = normalize(wi + wr);
    let w = wi.z + wr.z;
    let aligned = 1.0 + dot(wi, wr);
    var factor = fresnel_ratio(dot(half_vector, wr)) * aligned * aligned / (w * w * wr.z);
#ifdef SHADOWING
    factor *= shadowing(wi, wr);
#endif
    return factor;
}

// Path difference (u, v, w) = -wi - wr in the frame of the surface; w is between -2 and 0.
fn path_difference(wi: vec3f, wr: vec3f) -> vec3f {
    let path = -wi - wr;
#ifdef ROTATED
    let turn = textureLoad(spectrum, vec2i(0, 1), 0);
    return vec3f(turn.x * path.x + turn.y * path.y, turn.x * path.y - turn.y * path.x, path.z);
#else
    return path;
#endif
}
