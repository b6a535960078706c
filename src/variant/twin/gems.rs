//! The order sum of GPU Gems in f64; see `templates/gems.wgsl`.

use glam::DVec3;

use crate::field::reference::Directions;
use crate::optics::path_difference;

use super::Twin;

/// Number of orders in the sum.
const ORDER_COUNT: u32 = 8;
/// Sharpness of the highlight, 1/µm.
const ROUGHNESS: f64 = 10.0;

/// Tristimulus values of the chapter's colour, taken as linear sRGB.
pub fn tristimulus(twin: &Twin<'_>, Directions { wi, wr }: Directions) -> [f64; 3] {
    if !(wi.z > 0.0 && wr.z > 0.0) {
        return [0.0; 3];
    }
    let path = path_difference(wi, wr, twin.rotate_deg);
    let [x_um, y_um, ..] = twin.spectrum.load(0, 0, 0);
    let shift = (x_um * path.x + y_um * path.y).abs();
    from_rgb(orders(shift) + highlight(shift, path.z))
}

/// Sum of the colours of all orders. `shift`: path difference between grooves, µm.
fn orders(shift: f64) -> DVec3 {
    (1..=ORDER_COUNT).map(|n| rainbow(shift / f64::from(n))).sum()
}

/// Three parabolas over 0.5 to 1 µm: blue, green, red.
fn rainbow(lambda_um: f64) -> DVec3 {
    let y = 2.0 * lambda_um - 1.0;
    bump(4.0 * (DVec3::splat(y) - DVec3::new(0.75, 0.5, 0.25)))
}

/// `1 - x²`, at least 0.
fn bump(x: DVec3) -> DVec3 {
    (DVec3::ONE - x * x).max(DVec3::ZERO)
}

/// White highlight about the mirror direction, narrow across the grooves.
fn highlight(shift: f64, w: f64) -> DVec3 {
    let e = ROUGHNESS * shift / w;
    DVec3::splat((-e * e).exp())
}

/// Linear sRGB to tristimulus values, IEC 61966-2-1.
fn from_rgb(rgb: DVec3) -> [f64; 3] {
    [
        DVec3::new(0.4124, 0.3576, 0.1805).dot(rgb),
        DVec3::new(0.2126, 0.7152, 0.0722).dot(rgb),
        DVec3::new(0.0193, 0.1192, 0.9505).dot(rgb),
    ]
}
