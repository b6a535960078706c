//! Rosettes of curves that cross, as on banknotes.
//!
//! A rosette is the curves `r = R + A cos(nθ + kδ)`, k = 0 … K-1, `δ = 2π/K`. Through each place between `R - A` and `R + A` two of
//! these families pass: with `s = (r - R)/A`, the curves are where `h± = K (nθ ± acos s)/2π` is a whole number. Both touch the
//! envelopes and cross in between. So they divide the ring into diamonds, the cells.

use std::f64::consts::TAU;

use glam::DVec2;

use super::{Drawing, Groove};

/// One rosette; lengths in half the shorter side.
struct Rosette {
    radius: f64,
    amplitude: f64,
    lobes: f64,
    curves: f64,
}

const ROSETTES: [Rosette; 4] = [
    Rosette { radius: 0.155, amplitude: 0.125, lobes: 6.0, curves: 4.0 },
    Rosette { radius: 0.40, amplitude: 0.09, lobes: 14.0, curves: 5.0 },
    Rosette { radius: 0.635, amplitude: 0.115, lobes: 18.0, curves: 5.0 },
    Rosette { radius: 0.87, amplitude: 0.095, lobes: 32.0, curves: 4.0 },
];
/// Circles between them.
const CIRCLES: [f64; 5] = [0.296, 0.503, 0.762, 0.978, 0.991];
/// Place of the ratios of one family in their ranges; the other has twice that.
const THIRD: f64 = 1.0 / 3.0;
/// Half the width of a circle.
const HALF_CIRCLE: f64 = 0.0035;
/// Half the width of a curve.
const HALF_CURVE: f64 = 0.0045;
/// Least distance of a cell's foil from its curves.
const GAP: f64 = 0.0085;

impl Drawing {
    /// Curves have grooves along themselves; where two cross, they take turns on top. Every second cell is a grating with a radial
    /// direction and the ratios of its ring.
    pub(super) fn guilloche(&self, from: DVec2) -> Option<Groove> {
        let radius = from.length();
        let radial = from.y.atan2(from.x);
        if CIRCLES.iter().any(|circle| (radius - circle).abs() < HALF_CIRCLE) {
            return Some(self.groove(radial, self.period(0.5), 0.5));
        }
        for (ring, rosette) in ROSETTES.iter().enumerate() {
            let Rosette { radius: middle, amplitude, lobes, curves } = *rosette;
            let s = (radius - middle) / amplitude;
            if s.abs() >= 1.0 {
                continue;
            }
            let per_turn = curves / TAU;
            // along the circle, and along the radius: the gradient of each family
            let along = per_turn * lobes / radius;
            let outwards = per_turn / (amplitude * (1.0 - s * s).sqrt());
            let (around, lag) = (per_turn * lobes * radial, per_turn * s.acos());
            let [first, second] = [around - lag, around + lag];
            let away = |h: f64| (h - h.round()).abs() / along.hypot(outwards);
            let (near, far) = (away(first), away(second));
            let (on_first, on_second) = (near < HALF_CURVE, far < HALF_CURVE);
            let first_on_top = (first.round() + second.round()).rem_euclid(2.0) < 1.0;
            // where s grows, acos falls
            if on_first && (first_on_top || !on_second) {
                let angle_rad = radial + along.atan2(outwards);
                return Some(self.groove(angle_rad, self.period(THIRD), THIRD));
            }
            if on_second {
                let angle_rad = radial + along.atan2(-outwards);
                return Some(self.groove(angle_rad, self.period(2.0 * THIRD), 2.0 * THIRD));
            }
            let is_filled = (first.floor() + second.floor()).rem_euclid(2.0) < 1.0;
            let share = (ring + 1) as f64 / (ROSETTES.len() + 1) as f64;
            return (is_filled && near.min(far) > GAP)
                .then(|| self.groove(radial, self.period(share), share));
        }
        None
    }
}
