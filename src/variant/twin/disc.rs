//! Orders under a disc in f64; see `templates/disc.wgsl`.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use crate::variant::Orders;

use super::Twin;
use super::lamps::{Cap, under_caps};

/// Tristimulus values of the radiance under a disc of irradiance 1.
pub fn tristimulus_disc(
    twin: &Twin<'_>,
    form: &Orders,
    axis: DVec3,
    radius_rad: f64,
    wr: DVec3,
) -> [f64; 3] {
    let cap = disc_cap(axis, radius_rad);
    let sine_squared = cap.1 * (1.0 - 0.25 * cap.1);
    (under_caps(twin, form, &[cap], cap, wr) / (PI * sine_squared)).to_array()
}

/// A disc as a cap.
pub fn disc_cap(axis: DVec3, radius_rad: f64) -> Cap {
    let sine = (0.5 * radius_rad.clamp(1e-4, FRAC_PI_2)).sin();
    (axis, 4.0 * sine * sine)
}
