//! Orders under a disc in f64; see `templates/disc.wgsl`.

use std::f64::consts::PI;

use glam::DVec3;

use crate::variant::Orders;

use super::Twin;
use super::lamps::{Caps, disc_chord_squared};

/// Tristimulus values of the radiance under a disc of irradiance 1.
pub fn tristimulus_disc(
    twin: &Twin<'_>,
    form: &Orders,
    axis: DVec3,
    radius_rad: f64,
    wr: DVec3,
) -> [f64; 3] {
    tristimulus_disc_coloured(twin, form, (axis, radius_rad), DVec3::ONE, wr)
}

/// The same under a disc whose irradiance is a colour in linear sRGB.
pub fn tristimulus_disc_coloured(
    twin: &Twin<'_>,
    form: &Orders,
    (axis, radius_rad): (DVec3, f64),
    colour: DVec3,
    wr: DVec3,
) -> [f64; 3] {
    let chord_squared = disc_chord_squared(radius_rad);
    let sine_squared = chord_squared * (1.0 - 0.25 * chord_squared);
    let seen = Caps::disc(axis, radius_rad).seen(twin, form, colour, wr);
    (seen / (PI * sine_squared)).to_array()
}
