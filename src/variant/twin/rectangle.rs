//! Orders under a spherical quadrilateral in f64; see `templates/rectangle.wgsl`.

use glam::DVec3;

use crate::variant::Orders;

use super::Twin;
use super::lamps::{Cap, under_caps};

/// Tristimulus values of the radiance under a quadrilateral of radiance 1.
pub fn tristimulus_rectangle(
    twin: &Twin<'_>,
    form: &Orders,
    corners: [DVec3; 4],
    wr: DVec3,
) -> [f64; 3] {
    let (caps, bounds) = rectangle_caps(corners);
    under_caps(twin, form, &caps, bounds, wr).to_array()
}

/// A quadrilateral as an intersection of hemispheres, and a cap that contains it.
pub fn rectangle_caps(corners: [DVec3; 4]) -> ([Cap; 4], Cap) {
    let middle = corners.iter().sum::<DVec3>().normalize();
    let next = |i: usize| corners[(i + 1) % 4];
    let turning: DVec3 = (0..4).map(|i| corners[i].cross(next(i))).sum();
    let side = if turning.dot(middle) > 0.0 { 1.0 } else { -1.0 };
    let caps = [0, 1, 2, 3].map(|i| (edge_normal(corners[i], next(i), side, middle), 2.0));
    let farthest = corners.iter().map(|c| c.distance_squared(middle)).fold(0.0, f64::max);
    (caps, (middle, farthest))
}

fn edge_normal(start: DVec3, end: DVec3, side: f64, middle: DVec3) -> DVec3 {
    let normal = side * start.cross(end);
    if normal.length_squared() < 1e-12 { middle } else { normal.normalize() }
}
