//- Twin: src/optics/matter.rs with its parts in src/optics/gain.rs, and src/optics/directions.rs for `path_difference`.

#ifdef MATERIAL
// The gain, the factor in front of the interference term, without the reflectance of the material (Stam 1999, eqs. 7
// and 11).

#ifdef COVER
// Direction inside the cover, from a unit vector outside.
fn inside(direction: vec3f) -> vec3f {
    let plane = direction.xy / COVER_INDEX;
    return vec3f(plane, sqrt(max(0.0, 1.0 - dot(plane, plane))));
}

// Transmittance of the cover's face for s and p polarisation, 0 to 1, from the cosines outside and inside (Fresnel).
fn transmittance(above: f32, below: f32) -> vec2f {
    let s = (above - COVER_INDEX * below) / (above + COVER_INDEX * below);
    let p = (COVER_INDEX * above - below) / (COVER_INDEX * above + below);
    return vec2f(1.0 - s * s, 1.0 - p * p);
}

// Share of the light that crosses the cover's face twice, of the polarisation that counts, or of both.
fn crossed(wi: vec3f, light: vec3f, wr: vec3f, viewer: vec3f) -> f32 {
    let in_share = transmittance(wi.z, light.z);
    let out_share = transmittance(wr.z, viewer.z);
#ifdef TRANSVERSE_ELECTRIC
    return in_share.x * out_share.x;
#else
#ifdef TRANSVERSE_MAGNETIC
    return in_share.y * out_share.y;
#else
    return 0.25 * (in_share.x + in_share.y) * (out_share.x + out_share.y);
#endif
#endif
}

#endif
#else
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

#endif
#ifdef SHADOWING
// Shadowing and masking of V-cavities, 0 to 1 (Torrance and Sparrow 1967).
fn shadowing(wi: vec3f, wr: vec3f) -> f32 {
    let half_vector = normalize(wi + wr);
    return min(1.0, 2.0 * half_vector.z * min(wi.z, wr.z) / dot(half_vector, wr));
}
#endif

#ifdef MATERIAL
// The obliquity factor O times the cosine of the light, times the shadowing. O is (1 + wi·wr)² / (cos θi cos θr w²), or for
// one polarisation 4 cos θi cos θr / w² (the electric field along the grooves) or 4 (1 - s)² / (cos θi cos θr w²) (the
// magnetic field), s = -αi·αr. Under a cover the directions are those inside, and the result has the transmittances of
// its face. It is zero where a direction is at or below the horizon; a millionth above it counts as at it, since a
// cosine is rounded that much.
fn gain(wi: vec3f, wr: vec3f) -> f32 {
    if (!(wi.z > 1e-6 && wr.z > 1e-6)) {
        return 0.0;
    }
#ifdef COVER
    let light = inside(wi);
    let viewer = inside(wr);
    // a cone of light is narrower inside
    var factor = crossed(wi, light, wr, viewer) * wi.z / light.z;
#else
    let light = wi;
    let viewer = wr;
    var factor = 1.0;
#endif
    let w = light.z + viewer.z;
#ifdef UNPOLARISED
    let parts = polarised(light, viewer);
    factor *= 2.0 * (parts.x + parts.y) / (w * w * viewer.z);
#else
#ifdef TRANSVERSE_ELECTRIC
    factor *= 4.0 * polarised(light, viewer).x / (w * w * viewer.z);
#else
#ifdef TRANSVERSE_MAGNETIC
    factor *= 4.0 * polarised(light, viewer).y / (w * w * viewer.z);
#else
    let aligned = 1.0 + dot(light, viewer);
    factor *= aligned * aligned / (w * w * viewer.z);
#endif
#endif
#endif
#ifdef SHADOWING
    factor *= shadowing(light, viewer);
#endif
    return factor;
}

#ifdef POLARISED
// Squares of cos θi cos θr and of 1 + αi·αr, to which the intensities of s and p polarisation are proportional.
fn polarised(light: vec3f, viewer: vec3f) -> vec2f {
    let product = light.z * viewer.z;
    let across = 1.0 + dot(light.xy, viewer.xy);
    return vec2f(product * product, across * across);
}

#endif
// What the reflectance depends on: the cosine between half vector and viewer on the relief, 0 to 1, and the share of s
// polarisation.
fn facing_of(wi: vec3f, wr: vec3f) -> vec2f {
#ifdef COVER
    let light = inside(wi);
    let viewer = inside(wr);
#else
    let light = wi;
    let viewer = wr;
#endif
    let cos_half = dot(normalize(light + viewer), viewer);
#ifdef UNPOLARISED
    let parts = polarised(light, viewer);
    return vec2f(cos_half, parts.x / max(parts.x + parts.y, 1e-20));
#else
    return vec2f(cos_half, 0.5);
#endif
}
#else
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
#endif

#ifdef COVER
// Phase per height divided by the wave number in air, at 550 nm: the index of the cover times w inside, negative.
fn depth(wi: vec3f, wr: vec3f) -> f32 {
    return -COVER_INDEX * (inside(wi).z + inside(wr).z);
}

// Path difference (u, v) = -(wi + wr).xy in the frame of the surface, and the phase per height divided by the wave number.
#else
// Path difference (u, v, w) = -wi - wr in the frame of the surface; w is between -2 and 0.
#endif
fn path_difference(wi: vec3f, wr: vec3f) -> vec3f {
#ifdef COVER
    let path = vec3f(-wi.xy - wr.xy, depth(wi, wr));
#else
    let path = -wi - wr;
#endif
#ifdef TURNED
    let turn = turn_of_surface();
    return vec3f(turn.x * path.x + turn.y * path.y, turn.x * path.y - turn.y * path.x, path.z);
#else
    return path;
#endif
}
#ifdef TURNED

// Cosine and sine of the angle of the relief.
fn turn_of_surface() -> vec2f {
#ifdef PATTERN
#ifdef ROTATED
    let own = textureLoad(spectrum, vec2i(0, 1), 0);
    return vec2f(own.x * pattern.x - own.y * pattern.y, own.x * pattern.y + own.y * pattern.x);
#else
    return pattern.xy;
#endif
#else
    return textureLoad(spectrum, vec2i(0, 1), 0).xy;
#endif
}
#endif
