//! A cap of the sphere.

use std::f64::consts::PI;

use glam::DVec3;

/// All directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cap {
    /// Unit vector of its middle.
    pub axis: DVec3,
    /// Angle between the axis and its edge, 0 to π.
    pub radius_rad: f64,
}

impl Cap {
    /// Sine of half the angle between a direction and the axis, subtracted from that of the edge: positive inside. It
    /// keeps its precision for caps much smaller than the sun, whose cosine is nearly 1.
    pub fn margin(&self, wi: DVec3) -> f64 {
        (0.5 * self.radius_rad).sin() - 0.5 * (wi - self.axis).length()
    }

    /// Radiance of a uniform cap of that irradiance, perpendicular to its axis: `E/(π sin² a)`. The radius is at most π/2.
    pub fn radiance(&self, irradiance: f64) -> f64 {
        irradiance / (PI * self.radius_rad.sin().powi(2))
    }
}
