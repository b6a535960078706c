// The order sum of "Simulating Diffraction" (J. Stam, chapter 8 of GPU Gems, 2004), for comparison: a grating of one
// period, a rainbow for each order's wavelength, a highlight in place of the zero order. Its constants are the chapter's;
// roughness and colour of the highlight, which it leaves to the artist, are chosen here.

// Row 0, first texel: the period as a vector in µm, from one groove to the next; row 1: cosine and sine of the surface's
// rotation.
@group(0) @binding(2) var spectrum: texture_2d<f32>;

// Orders that are added.
const ORDER_COUNT: i32 = 8;
// Sharpness of the highlight, 1/µm.
const ROUGHNESS: f32 = 10.0;

// Tristimulus values of the chapter's colour, taken as linear sRGB.
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    if (!(wi.z > 0.0 && wr.z > 0.0)) {
        return vec3f(0.0);
    }
    let path = path_difference(wi, wr);
    let shift = abs(dot(textureLoad(spectrum, vec2i(0, 0), 0).xy, path.xy));
    return from_rgb(orders(shift) + highlight(shift, path.z));
}

// The colours of the wavelengths whose orders fall into a direction with a path difference, in µm, between grooves.
fn orders(shift: f32) -> vec3f {
    var rgb = vec3f(0.0);
    for (var n = 1; n <= ORDER_COUNT; n++) {
        rgb += rainbow(shift / f32(n));
    }
    return rgb;
}

// Three parabolas over 0.5 to 1 µm, the chapter's range of visible light: blue, green, red.
fn rainbow(lambda_um: f32) -> vec3f {
    let y = 2.0 * lambda_um - 1.0;
    return bump(4.0 * (vec3f(y) - vec3f(0.75, 0.5, 0.25)));
}

// 1 - x², and nothing below.
fn bump(x: vec3f) -> vec3f {
    return max(vec3f(1.0) - x * x, vec3f(0.0));
}

// White, around the mirror direction, narrow across the grooves.
fn highlight(shift: f32, w: f32) -> vec3f {
    let e = ROUGHNESS * shift / w;
    return vec3f(exp(-e * e));
}

// Linear sRGB to tristimulus values, IEC 61966-2-1.
fn from_rgb(rgb: vec3f) -> vec3f {
    return vec3f(
        dot(vec3f(0.4124, 0.3576, 0.1805), rgb),
        dot(vec3f(0.2126, 0.7152, 0.0722), rgb),
        dot(vec3f(0.0193, 0.1192, 0.9505), rgb),
    );
}
