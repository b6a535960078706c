// The gain in front of the interference term, after Stam 1999 with Schlick's reflectance and V-cavities.

// Schlick's reflectance over its value at normal incidence.
fn fresnel_ratio(cos_half: f32) -> f32 {
    let amplitude = (REFRACTIVE_INDEX - 1.0) / (REFRACTIVE_INDEX + 1.0);
    let one_minus = 1.0 - cos_half;
    let squared = one_minus * one_minus;
    return 1.0 + (1.0 / (amplitude * amplitude) - 1.0) * squared * squared * one_minus;
}

#ifdef SHADOWING
// Shadowing and masking of V-cavities.
fn shadowing(wi: vec3f, wr: vec3f) -> f32 {
    let half_vector = normalize(wi + wr);
    return min(1.0, 2.0 * half_vector.z * min(wi.z, wr.z) / dot(half_vector, wr));
}
#endif

// R/R0 (1 + wi·wr)² / (w² cos θr) S, zero where either direction is at or below the horizon.
fn gain(wi: vec3f, wr: vec3f) -> f32 {
    if (!(wi.z > 0.0 && wr.z > 0.0)) {
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

// (u, v, w) = -wi - wr in the frame of the surface.
fn path_difference(wi: vec3f, wr: vec3f) -> vec3f {
    let path = -wi - wr;
#ifdef ROTATED
    let turn = textureLoad(spectrum, vec2i(0, 1), 0);
    return vec3f(turn.x * path.x + turn.y * path.y, turn.x * path.y - turn.y * path.x, path.z);
#else
    return path;
#endif
}
