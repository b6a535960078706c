//! Directions, and the path difference of a pair of them on a surface.

use glam::{DVec2, DVec3};

/// Unit vector of the polar angles `theta_deg` (from the normal) and `phi_deg` (from `+x` towards `+y`).
pub fn direction(theta_deg: f64, phi_deg: f64) -> DVec3 {
    let ((sin_theta, cos_theta), (sin_phi, cos_phi)) =
        (theta_deg.to_radians().sin_cos(), phi_deg.to_radians().sin_cos());
    DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

/// `(u, v, w) = -wi - wr` in the frame of a surface that is rotated by `rotate_deg` about its normal.
pub fn path_difference(wi: DVec3, wr: DVec3, rotate_deg: f64) -> DVec3 {
    let uvw = -wi - wr;
    if rotate_deg == 0.0 {
        return uvw;
    }
    let DVec2 { x: cos, y: sin } = turn_of_surface(rotate_deg);
    DVec3::new(cos * uvw.x + sin * uvw.y, cos * uvw.y - sin * uvw.x, uvw.z)
}

/// Cosine and sine of the angle of the relief.
fn turn_of_surface(rotate_deg: f64) -> DVec2 {
    DVec2::from_angle(rotate_deg.to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotating_the_surface_is_turning_both_directions_back() {
        let (wi, wr) = (direction(30.0, 20.0), direction(50.0, 130.0));
        let turned =
            path_difference(direction(30.0, 20.0 - 33.0), direction(50.0, 130.0 - 33.0), 0.0);
        assert!((path_difference(wi, wr, 33.0) - turned).length() < 1e-14);
    }
}
