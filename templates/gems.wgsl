//- Twin: src/variant/twin/gems.rs.

// The order sum of "Simulating Diffraction" (J. Stam, GPU Gems, 2004, chapter 8), for comparison: a grating of one
// period, a rainbow over each order's wavelength, a highlight in place of the zero order. The constants are those of
// the chapter. The chapter leaves the roughness and the colour of the highlight to the artist; here they are 10 per µm
// and white.

// Row 0, first texel: the vector from one groove to the next, in µm. Row 1: cosine and sine of the surface's rotation.
@group(0) @binding(2) var spectrum: texture_2d<f32>;

const ORDER_COUNT: i32 = 8; // number of diffraction orders in the sum
const ROUGHNESS: f32 = 10.0; // sharpness of the highlight, 1/µm

// X, Y, Z of the chapter's colour, taken as linear sRGB. The unit is arbitrary.
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    if (!(wi.z > 0.0 && wr.z > 0.0)) {
        return vec3f(0.0);
    }
    let path = path_difference(wi, wr);
    let shift = abs(dot(textureLoad(spectrum, vec2i(0, 0), 0).xy, path.xy));
    return from_rgb(orders(shift) + highlight(shift, path.z));
}

// Sum of the colours of all orders: order n has the wavelength `shift`/n. `shift`: path difference between grooves, µm.
fn orders(shift: f32) -> vec3f {
    var rgb = vec3f(0.0);
    for (var n = 1; n <= ORDER_COUNT; n++) {
        rgb += rainbow(shift / f32(n));
    }
    return rgb;
}

// Colour of a wavelength: three parabolas, red, green and blue, over the chapter's range of visible light, 0.5 to 1 µm.
fn rainbow(lambda_um: f32) -> vec3f {
    let y = 2.0 * lambda_um - 1.0;
    return bump(4.0 * (vec3f(y) - vec3f(0.75, 0.5, 0.25)));
}

// 1 - x², at least 0.
fn bump(x: vec3f) -> vec3f {
    return max(vec3f(1.0) - x * x, vec3f(0.0));
}

// White highlight about the mirror direction, 0 to 1, narrow across the grooves.
fn highlight(shift: f32, w: f32) -> vec3f {
    let e = ROUGHNESS * shift / w;
    return vec3f(exp(-e * e));
}

// X, Y, Z of linear sRGB, IEC 61966-2-1.
fn from_rgb(rgb: vec3f) -> vec3f {
    return vec3f(
        dot(vec3f(0.4124, 0.3576, 0.1805), rgb),
        dot(vec3f(0.2126, 0.7152, 0.0722), rgb),
        dot(vec3f(0.0193, 0.1192, 0.9505), rgb),
    );
}
