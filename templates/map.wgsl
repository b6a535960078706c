//- Twin of the geometry: src/optics/brdf_map.rs.

// A full-screen picture of the hemisphere of viewing directions under one light.

struct Params {
#ifdef PATTERN
    // xyz: direction to the light, a unit vector; w: angle of the pattern, radians
    light: vec4f,
    // xy: size of the picture in pixels; z: period of the pattern, relative to that of the surface; w: its depth
    size: vec4f,
#else
    // xyz: direction to the light, a unit vector; w: unused
    light: vec4f,
    // xy: size of the picture in pixels; zw: unused
    size: vec4f,
#endif
}
@group(0) @binding(0) var<uniform> params: Params;

struct FullScreen {
    @builtin(position) position: vec4f,
    @location(0) place: vec2f,
}

// One triangle that covers the screen. `place` runs from -1 to 1 on both axes, y up.
@vertex
fn vert(@builtin(vertex_index) index: u32) -> FullScreen {
    let place = vec2f(select(-1.0, 3.0, index == 1u), select(-1.0, 3.0, index == 2u));
    return FullScreen(vec4f(place, 0.0, 1.0), place);
}

// Pixel that contains `place`, counted from the lower left. It is exact, however the driver interpolates.
fn pixel_of(place: vec2f) -> vec2f {
    return floor((0.5 * place + 0.5) * params.size.xy);
}

// Direction to the viewer of a pixel, seen from above the hemisphere; z is -1 outside the disc.
fn view_direction(pixel: vec2f) -> vec3f {
    let centre = (2.0 * pixel + 1.0) / params.size.xy - 1.0;
    let squared = dot(centre, centre);
    return vec3f(centre, select(-1.0, sqrt(max(0.0, 1.0 - squared)), squared < 1.0));
}

// Linear RGB of a pixel, alpha 1; all zero outside the disc.
@fragment
fn map(@location(0) place: vec2f) -> @location(0) vec4f {
    let wr = view_direction(pixel_of(place));
    if (wr.z < 0.0) {
        return vec4f(0.0);
    }
#ifdef PATTERN
    let pattern = vec4f(cos(params.light.w), sin(params.light.w), params.size.zw);
#endif
    return vec4f(diffraction(params.light.xyz, wr), 1.0);
}
