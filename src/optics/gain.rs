//! The gain factor in front of the interference term.

use glam::DVec3;

use crate::defines::Defines;
use crate::plan::Optics;

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
const HORIZON: f64 = 1e-6;

/// The gain `C(wi, wr) = R/R0 · (1 + wi·wr)² / (w² cos θr) · S`, relative to a mirror at normal incidence (Stam 1999,
/// eqs. 7 and 11). It is zero where either direction is at or below the horizon, within a cosine of 1e-6. Without `S` it
/// diverges at grazing exit.
pub fn gain(wi: DVec3, wr: DVec3, optics: &Optics) -> f64 {
    if !(wi.z > HORIZON && wr.z > HORIZON) {
        return 0.0;
    }
    let half = (wi + wr).normalize();
    let w = wi.z + wr.z;
    let obliquity = (1.0 + wi.dot(wr)).powi(2) / (w * w * wr.z);
    let shadow = if optics.shadowing { shadowing(wi, wr) } else { 1.0 };
    fresnel_ratio(half.dot(wr), optics.refractive_index) * obliquity * shadow
}

/// Flags and constants of the template `gain`.
pub fn define(optics: &Optics, into: &mut Defines) {
    into.flag("SHADOWING", optics.shadowing);
    let index = optics.refractive_index;
    into.number("REFRACTIVE_INDEX", index, "refractive index of the material, relative to air");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::direction;

    #[test]
    fn mirror_at_normal_incidence_has_gain_one_and_forty_degrees_less() {
        let optics = Optics::standard();
        let up = DVec3::Z;
        assert!((gain(up, up, &optics) - 1.0).abs() < 1e-15);
        let tilted = gain(direction(40.0, 0.0), direction(40.0, 180.0), &optics);
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
        let optics = Optics::standard();
        for (wi, wr) in [
            (DVec3::X, DVec3::Z),
            (DVec3::Z, DVec3::X),
            (direction(90.0, 30.0), DVec3::Z),
            (DVec3::Z, direction(90.0, 0.0)),
            (-DVec3::Z, DVec3::Z),
            (DVec3::Z, -DVec3::Z),
        ] {
            assert_eq!(gain(wi, wr, &optics), 0.0);
        }
    }

    #[test]
    fn shadowing_tames_grazing_exit() {
        let mut optics = Optics::standard();
        let (wi, wr) = (direction(20.0, 0.0), direction(89.999, 180.0));
        assert!(gain(wi, wr, &optics) < 100.0);
        optics.shadowing = false;
        assert!(gain(wi, wr, &optics) > 1000.0);
    }
}
