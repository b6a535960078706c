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
    Caps::rectangle(corners).seen(twin, form, wr).to_array()
}
