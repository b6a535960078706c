//! Orders under a spherical quadrilateral in f64; see `templates/rectangle.wgsl`.

use glam::DVec3;

use crate::variant::Orders;

use super::Twin;
use super::lamps::Caps;

/// Tristimulus values of the radiance under a quadrilateral of radiance 1.
pub fn tristimulus_rectangle(
    twin: &Twin<'_>,
    form: &Orders,
    corners: [DVec3; 4],
    wr: DVec3,
) -> [f64; 3] {
    tristimulus_rectangle_coloured(twin, form, corners, DVec3::ONE, wr)
}

/// The same under a quadrilateral whose radiance is a colour in linear sRGB.
pub fn tristimulus_rectangle_coloured(
    twin: &Twin<'_>,
    form: &Orders,
    corners: [DVec3; 4],
    colour: DVec3,
    wr: DVec3,
) -> [f64; 3] {
    Caps::rectangle(corners).seen(twin, form, colour, wr).to_array()
}
