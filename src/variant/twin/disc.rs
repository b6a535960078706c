//! Orders under a disc in f64; see `templates/disc.wgsl`.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use crate::variant::Orders;

use super::Twin;
use super::lamps::Caps;

/// Tristimulus values of the radiance under a disc of irradiance 1.
pub fn tristimulus_disc(
    twin: &Twin<'_>,
    form: &Orders,
    axis: DVec3,
    radius_rad: f64,
    wr: DVec3,
) -> [f64; 3] {
    let chord_squared = disc_chord_squared(radius_rad);
    let sine_squared = chord_squared * (1.0 - 0.25 * chord_squared);
    (Caps::disc(axis, radius_rad).seen(twin, form, wr) / (PI * sine_squared)).to_array()
}

/// Square of the chord from the axis of a disc to its edge.
pub fn disc_chord_squared(radius_rad: f64) -> f64 {
    4.0 * (0.5 * radius_rad.clamp(1e-4, FRAC_PI_2)).sin().powi(2)
}
