//! The colours of a snake like a corn snake (Pantherophis guttatus): saddles with dark edges on orange.

use crate::drivers::ColourMap;

/// Colours of the saddles, their edges, the ground between them, and the belly, linear sRGB.
const SADDLE: [f64; 3] = [0.36, 0.05, 0.018];
const EDGE: [f64; 3] = [0.035, 0.015, 0.01];
const GROUND: [f64; 3] = [0.55, 0.21, 0.055];
const BELLY: [f64; 3] = [0.62, 0.52, 0.38];

/// A picture. Columns run from head to tail, rows around the body: from one side of the belly over the back to the other side.
/// `length` is the body's length, in girths.
pub fn corn_snake(width: u32, height: u32, length: f64) -> ColourMap {
    let texel = |i: u32| {
        let along = (f64::from(i % width) + 0.5) / f64::from(width) * length;
        // 0 on the back, ±1 on the middle of the belly
        let around = 2.0 * (f64::from(i / width) + 0.5) / f64::from(height) - 1.0;
        let code =
            |c: f64| (255.0 * diffraction_shaders::optics::colour::srgb_encode(c)).round() as u8;
        let [r, g, b] = colour(along, around).map(code);
        [r, g, b, 255]
    };
    ColourMap { width, height, texels: (0..width * height).map(texel).collect() }
}

/// Linear colour at a position: `along` in girths, `around` from -1 to 1.
fn colour(along: f64, around: f64) -> [f64; 3] {
    let pitch = 0.52;
    let saddle = blotch(along, around, pitch, 0.0, [0.33, 0.36]);
    // smaller blotches on the sides, between the saddles
    let side = blotch(along, around.abs() - 0.56, pitch, 0.5, [0.2, 0.13]);
    let inside = saddle.min(side);
    let mottled = 1.0 + 0.12 * ripple(along, around);
    let back = mix(EDGE, SADDLE, smooth((-inside - 0.16) / 0.1));
    let back = mix(back, GROUND, smooth((inside + 0.02) / 0.06));
    // dark squares on the pale belly
    let cell = ((along / 0.23).floor() + (around.signum() + 1.0) / 2.0).rem_euclid(2.0);
    let belly = if cell < 1.0 && around.abs() > 0.84 { EDGE } else { BELLY };
    mix(back, belly, smooth((around.abs() - 0.74) / 0.05)).map(|c| (c * mottled).clamp(0.0, 1.0))
}

/// A row of ellipses with uneven outlines: below 0 inside of them. `half` and `wide` are their half axes, in girths and in half
/// turns.
fn blotch(along: f64, around: f64, pitch: f64, offset: f64, [half, wide]: [f64; 2]) -> f64 {
    let place = along / pitch + offset;
    let number = place.round();
    let size = 1.0 + 0.12 * (7.3 * number).sin();
    let x = (place - number) / (half * size) + 0.15 * ripple(along, around);
    let y = around / (wide * size);
    // squarish
    (x.powi(4) + y.powi(4)).powf(0.25) - 1.0
}

fn ripple(along: f64, around: f64) -> f64 {
    let (a, b) = (along * 29.0, around * 11.0);
    ((a + 2.0 * b.sin()).sin() + (1.7 * a - b).sin() * 0.6 + (2.3 * b + 0.4 * a).cos() * 0.5) / 2.1
}

fn smooth(x: f64) -> f64 {
    let t = x.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn mix(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * share)
}
