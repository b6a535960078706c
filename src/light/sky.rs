//! Surroundings that are given by a formula, and what all surroundings can tell.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Cap, Emitter};

/// Radiance around a surface, blurred as far as asked for.
pub trait Surroundings: Sync {
    /// Radiance from a direction, linear sRGB, blurred to a standard deviation in radians on each axis.
    fn seen(&self, direction: DVec3, spread_rad: f64) -> DVec3;
}

/// A sky of constant radiance with bright lobes. The radiance from a direction `d`, blurred to a standard deviation of s, is
/// `constant + Σ radiance·σ²/(σ² + s²)·exp(-(1 - d·axis)/(σ² + s²))`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sky {
    /// Linear sRGB.
    pub constant: DVec3,
    /// A lobe of no radiance is none.
    pub lobes: [Lobe; 2],
}

/// A bright part of a sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Unit vector to its middle.
    pub axis: DVec3,
    /// Standard deviation on each axis, radians.
    pub sigma_rad: f64,
    /// Radiance in its middle, linear sRGB.
    pub radiance: DVec3,
}

impl Default for Lobe {
    fn default() -> Lobe {
        Lobe { axis: DVec3::Z, sigma_rad: 1.0, radiance: DVec3::ZERO }
    }
}

impl Sky {
    /// A sky of the same radiance everywhere.
    pub fn everywhere(constant: DVec3) -> Sky {
        Sky { constant, ..Sky::default() }
    }

    /// The largest radiance of a channel, at most.
    pub fn brightest(&self) -> f64 {
        let sum = self.constant + self.lobes.iter().map(|lobe| lobe.radiance).sum::<DVec3>();
        sum.max_element()
    }
}

impl Surroundings for Sky {
    fn seen(&self, direction: DVec3, spread_rad: f64) -> DVec3 {
        let lobe = |lobe: &Lobe| {
            let own = lobe.sigma_rad * lobe.sigma_rad;
            let wide = own + spread_rad * spread_rad;
            // 1 - d·axis, without the digits that the difference would lose
            let apart = 0.5 * direction.distance_squared(lobe.axis);
            own / wide * (-apart / wide).exp() * lobe.radiance
        };
        let lit = self.lobes.iter().filter(|lobe| lobe.radiance != DVec3::ZERO);
        self.constant + lit.map(lobe).sum::<DVec3>()
    }
}

impl Emitter for Sky {
    fn bounds(&self) -> Cap {
        Cap { axis: DVec3::Z, radius_rad: PI }
    }

    fn margin(&self, _: DVec3) -> f64 {
        1.0
    }

    fn radiance(&self, wi: DVec3) -> DVec3 {
        self.seen(wi, 0.0)
    }

    fn grain_rad(&self) -> f64 {
        let lit = self.lobes.iter().filter(|lobe| lobe.radiance != DVec3::ZERO);
        lit.map(|lobe| 0.5 * lobe.sigma_rad).fold(PI, f64::min)
    }
}
