//! Tristimulus values, linear RGB, and the difference between two colours.

use colorimetry::lab::CieLab;
use colorimetry::observer::Observer;
use colorimetry::xyz::{RelXYZ, XYZ};
use glam::{DMat3, DVec3};

use crate::plan::Colour;

/// IEC 61966-2-1:1999, XYZ (D65, Y of white 1) to linear sRGB, row by row.
pub const XYZ_TO_SRGB: [[f64; 3]; 3] =
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];

/// XYZ to CIE RGB as the texts print it (eq. 3.7), multiplied from the left by the D65 white, which they apply a second
/// time. It serves to compare with their pictures; it is not a display's RGB.
pub const XYZ_TO_THESIS: [[f64; 3]; 3] = [
    [0.9505 * 0.41847, 0.9505 * -0.15866, 0.9505 * -0.082835],
    [-0.091169, 0.25243, 0.015708],
    [1.0890 * 0.00092090, 1.0890 * -0.0025498, 1.0890 * 0.17860],
];

/// The matrix from XYZ to the linear RGB of a colour profile, row by row.
pub fn rgb_matrix(colour: Colour) -> [[f64; 3]; 3] {
    match colour {
        Colour::Srgb => XYZ_TO_SRGB,
        Colour::Thesis => XYZ_TO_THESIS,
    }
}

/// Tristimulus values to linear RGB, not clamped.
pub fn to_rgb(xyz: [f64; 3], colour: Colour) -> [f64; 3] {
    rgb_matrix(colour).map(|row| row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2])
}

/// Linear RGB back to tristimulus values.
pub fn from_rgb(rgb: [f64; 3], colour: Colour) -> [f64; 3] {
    let rows = rgb_matrix(colour).map(DVec3::from);
    (DMat3::from_cols(rows[0], rows[1], rows[2]).transpose().inverse() * DVec3::from(rgb))
        .to_array()
}

/// Luminance of linear sRGB, 1 for white (IEC 61966-2-1).
pub fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// The sRGB transfer function (IEC 61966-2-1), on a linear component clamped to [0, 1].
pub fn srgb_encode(linear: f64) -> f64 {
    let c = linear.clamp(0.0, 1.0);
    if c <= 0.0031308 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// Brightness above which the tone map bends.
const KNEE: f64 = 0.6;

/// Maps linear colours into [0, 1] and keeps their hue. Negative components become 0. If the largest component `m` exceeds 0.6,
/// all are scaled so that it becomes `1 - 0.4·exp(-(m - 0.6)/0.4)`.
pub fn tone_map(rgb: [f64; 3]) -> [f64; 3] {
    let rgb = rgb.map(|c| if c > 0.0 { c } else { 0.0 });
    let most = rgb.iter().copied().fold(0.0, f64::max);
    if most <= KNEE {
        return rgb;
    }
    let room = 1.0 - KNEE;
    let bent = 1.0 - room * (-(most - KNEE) / room).exp();
    rgb.map(|c| (c / most).min(1.0) * bent)
}

/// CIEDE2000 between two tristimulus values relative to D65 with `Y = 1` (Luo, Cui & Rigg 2001, by `colorimetry`).
/// Components are first clipped to the range from black to white.
pub fn ciede2000(a: [f64; 3], b: [f64; 3]) -> f64 {
    let white = D65_WHITE.map(|c| c * 100.0);
    let lab = |xyz: [f64; 3]| {
        let clipped = std::array::from_fn(|c| (xyz[c] * 100.0).clamp(0.0, white[c]));
        CieLab::from_rxyz(RelXYZ::new(clipped, XYZ::new(white, Observer::Cie1931)))
    };
    lab(a).ciede2000(&lab(b)).unwrap_or(f64::NAN)
}

/// White point of D65 for the 2° observer, `Y = 1` (ASTM E308).
pub const D65_WHITE: [f64; 3] = [0.95047, 1.0, 1.08883];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rgb_goes_back_to_where_it_came_from() {
        for colour in [Colour::Srgb, Colour::Thesis] {
            let back = from_rgb(to_rgb([0.3, 0.5, 0.1], colour), colour);
            assert!(
                back.iter().zip([0.3, 0.5, 0.1]).all(|(a, b)| (a - b).abs() < 1e-14),
                "{back:?}"
            );
        }
    }

    #[test]
    fn colour_difference_is_zero_on_itself_and_large_on_black() {
        assert_eq!(ciede2000(D65_WHITE, D65_WHITE), 0.0);
        assert!((ciede2000(D65_WHITE, [0.0; 3]) - 100.0).abs() < 1e-6);
    }
}
