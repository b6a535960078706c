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

/// Unit vector to the inner side of an edge; the centre for an edge without length.
pub fn edge_normal(start: DVec3, end: DVec3, side: f64, centre: DVec3) -> DVec3 {
    let normal = side * start.cross(end);
    if normal.length_squared() < 1e-12 { centre } else { normal.normalize() }
}
