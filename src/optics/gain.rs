//! Parts of the gain, the factor in front of the interference term. [`super::Matter`] puts them together.

use glam::DVec3;

use crate::plan::Obliquity;

/// Reflectance at normal incidence, `((n-1)/(n+1))²`.
pub fn normal_reflectance(refractive_index: f64) -> f64 {
    ((refractive_index - 1.0) / (refractive_index + 1.0)).powi(2)
}

/// Schlick's reflectance over its value at normal incidence, `R(θh)/R0` (Schlick 1994, eq. 15).
///
/// Stam's `F` is an amplitude coefficient, so his `F²` is this `R`, and `R` enters only once.
pub fn fresnel_ratio(cos_half: f64, refractive_index: f64) -> f64 {
    1.0 + (1.0 / normal_reflectance(refractive_index) - 1.0) * (1.0 - cos_half).powi(5)
}

/// Shadowing and masking of V-cavities, `min(1, 2(n·h)(n·wr)/(h·wr), 2(n·h)(n·wi)/(h·wr))` (Torrance & Sparrow 1967).
pub fn shadowing(wi: DVec3, wr: DVec3) -> f64 {
    let half = (wi + wr).normalize();
    (2.0 * half.z * wi.z.min(wr.z) / half.dot(wr)).min(1.0)
}

/// Cosine up to which a direction is at the horizon: 90° in degrees becomes 6e-17, and 32-bit floats round to 6e-8.
pub(super) const HORIZON: f64 = 1e-6;

/// The gain of a dielectric in air, `C(wi, wr) = R/R0 · (1 + wi·wr)² / (w² cos θr) · S`, relative to a mirror at normal
/// incidence (Stam 1999, eqs. 7 and 11). It is zero where either direction is at or below the horizon, within a cosine of
/// 1e-6. Without `S` it diverges at grazing exit.
pub(super) fn schlick_gain(
    wi: DVec3,
    wr: DVec3,
    refractive_index: f64,
    has_shadowing: bool,
) -> f64 {
    if !(wi.z > HORIZON && wr.z > HORIZON) {
        return 0.0;
    }
    let half = (wi + wr).normalize();
    let w = wi.z + wr.z;
    let obliquity = (1.0 + wi.dot(wr)).powi(2) / (w * w * wr.z);
    let shadow = if has_shadowing { shadowing(wi, wr) } else { 1.0 };
    fresnel_ratio(half.dot(wr), refractive_index) * obliquity * shadow
}

/// The obliquity factor times the cosine of the light, in parts for s and p polarisation. With
/// `s = -αi·αr`, the signed product of the sines in the plane of incidence of a grating:
///
/// * TE, `4 cos θi cos θr/w²`, and TM, `4 (1 - s)²/(cos θi cos θr w²)`, are exact for shallow reliefs of a perfect
///   conductor whose grooves are across the plane of incidence (Rice 1951, to first order in the height).
/// * The mean of both is exact to first order for unpolarised light in every direction.
/// * Stam's `(1 + wi·wr)²/(cos θi cos θr w²)` is the square of the mean of their roots (Stam 1999, eq. 7).
pub(super) fn obliquity(wi: DVec3, wr: DVec3, of: Obliquity) -> [f64; 2] {
    let w = wi.z + wr.z;
    let aligned = 1.0 + wi.dot(wr);
    let below = w * w * wr.z;
    let [s, p] = polarised(wi, wr).map(|square| 4.0 * square / below);
    match of {
        Obliquity::Stam => [0.5 * aligned * aligned / below; 2],
        Obliquity::Unpolarised => [0.5 * s, 0.5 * p],
        Obliquity::Te => [s, 0.0],
        Obliquity::Tm => [0.0, p],
    }
}

/// Squares of `cos θi cos θr` and of `1 - s`, to which the intensities of s and p polarisation are proportional.
fn polarised(wi: DVec3, wr: DVec3) -> [f64; 2] {
    let product = wi.z * wr.z;
    let across = 1.0 + wi.truncate().dot(wr.truncate());
    [product * product, across * across]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::direction;

    #[test]
    fn mirror_at_normal_incidence_has_gain_one_and_forty_degrees_less() {
        let up = DVec3::Z;
        assert!((schlick_gain(up, up, 1.5, true) - 1.0).abs() < 1e-15);
        let tilted = schlick_gain(direction(40.0, 0.0), direction(40.0, 180.0), 1.5, true);
        assert!((tilted - 0.78).abs() < 0.005, "{tilted}");
    }

    /// The texts square Schlick's value once more, which gives a different number at 80°.
    #[test]
    fn reflectance_enters_once() {
        let cos = 80.0_f64.to_radians().cos();
        let ratio = fresnel_ratio(cos, 1.5);
        let r = 0.04 + 0.96 * (1.0 - cos).powi(5);
        assert!((ratio - r / 0.04).abs() < 1e-12 && (ratio - (r / 0.04).powi(2)).abs() > 1.0);
    }

    #[test]
    fn nothing_below_the_horizon() {
        for (wi, wr) in [
            (DVec3::X, DVec3::Z),
            (DVec3::Z, DVec3::X),
            (direction(90.0, 30.0), DVec3::Z),
            (DVec3::Z, direction(90.0, 0.0)),
            (-DVec3::Z, DVec3::Z),
            (DVec3::Z, -DVec3::Z),
        ] {
            assert_eq!(schlick_gain(wi, wr, 1.5, true), 0.0);
        }
    }

    #[test]
    fn shadowing_tames_grazing_exit() {
        let (wi, wr) = (direction(20.0, 0.0), direction(89.999, 180.0));
        assert!(schlick_gain(wi, wr, 1.5, true) < 100.0);
        assert!(schlick_gain(wi, wr, 1.5, false) > 1000.0);
    }
}
