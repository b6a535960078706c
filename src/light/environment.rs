//! A map of the surroundings: a panorama of radiance over all directions.

pub mod filtered;
mod lamps;
mod read;
mod studio;
mod write;

use std::f64::consts::{PI, TAU};
use std::fmt;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::{Cap, Emitter};
use crate::hash::sha256;

pub use lamps::{Lamp, LampSearch, MAX_LAMP_DEG, MAX_LAMPS, TakenOut};
pub use studio::Studio;

/// Radiance over all directions as a picture. The centre of pixel (row i, column j) of h × w is at `theta = (i + 0.5)/h·180°`,
/// `phi = (j + 0.5)/w·360° - 180°`. Between centres it is bilinear. Columns go on at the other side; beyond the centres of the
/// first and the last row it is constant along theta.
#[derive(Clone, PartialEq)]
pub struct Panorama {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Linear sRGB, `[row][column]`, finite and not negative.
    pub texels: Vec<[f32; 3]>,
}

impl fmt::Debug for Panorama {
    /// Its size, and a hash of its texels.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bytes: Vec<u8> = self.texels.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        write!(f, "Panorama({} × {}, {})", self.width, self.height, sha256(&bytes))
    }
}

impl Panorama {
    /// Radiance at an angle from the axis, and about it, in radians.
    pub fn at(&self, theta_rad: f64, phi_rad: f64) -> DVec3 {
        let row = theta_rad / PI * self.height as f64 - 0.5;
        let column = (phi_rad + PI) / TAU * self.width as f64 - 0.5;
        let (top, left) = (row.floor(), column.floor());
        let (down, right) = (row - top, column - left);
        let texel = |row: f64, column: f64| {
            let row = row.clamp(0.0, self.height as f64 - 1.0) as usize;
            let column = column.rem_euclid(self.width as f64) as usize % self.width;
            DVec3::from(self.texels[row * self.width + column].map(f64::from))
        };
        let line = |row: f64| texel(row, left).lerp(texel(row, left + 1.0), right);
        line(top).lerp(line(top + 1.0), down)
    }

    /// The solid angle that each pixel of a row stands for: the integral of what it adds between centres. All pixels have 4π.
    pub fn solid_angles(&self) -> Vec<f64> {
        let step = PI / self.height as f64;
        // from its centre towards a pole: constant in the last row, else falling to the next centre
        let half = |row: usize| {
            let centre = (row as f64 + 0.5) * step;
            match row {
                0 => 1.0 - centre.cos(),
                _ => (centre.sin() - (centre - step).sin()) / step - centre.cos(),
            }
        };
        let both = |row: usize| half(row) + half(self.height - 1 - row);
        (0..self.height).map(|row| TAU / self.width as f64 * both(row)).collect()
    }

    /// The integral over all directions, linear sRGB.
    pub fn integral(&self) -> DVec3 {
        let rows = self.texels.chunks_exact(self.width).zip(self.solid_angles());
        let row = |(texels, part): (&[[f32; 3]], f64)| {
            part * texels.iter().map(|texel| DVec3::from(texel.map(f64::from))).sum::<DVec3>()
        };
        rows.map(row).sum()
    }

    /// Radiance from a unit vector: theta counts from z, phi from x towards y.
    pub fn towards(&self, direction: DVec3) -> DVec3 {
        let theta = direction.truncate().length().atan2(direction.z);
        self.at(theta, direction.y.atan2(direction.x))
    }

    /// Direction of a place in a picture of that size, in pixels: the centre of the first is (0.5, 0.5).
    pub fn direction([width, height]: [usize; 2], row: f64, column: f64) -> DVec3 {
        let theta = row / height as f64 * PI;
        let phi = column / width as f64 * TAU - PI;
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    /// The angle between neighbouring pixels, radians.
    pub fn pixel_rad(&self) -> f64 {
        (PI / self.height as f64).min(TAU / self.width as f64)
    }
}

/// A panorama around a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// The picture.
    pub panorama: Arc<Panorama>,
    /// Factor on its radiance.
    pub scale: f64,
    /// What the picture has at phi stands at `phi + rotate_deg`.
    pub rotate_deg: f64,
}

impl Environment {
    /// Radiance from a direction, linear sRGB: theta counts from the normal, phi from the tangent.
    pub fn radiance(&self, wi: DVec3) -> DVec3 {
        let turn = DVec2::from_angle(-self.rotate_deg.to_radians());
        self.scale * self.panorama.towards(turn.rotate(wi.truncate()).extend(wi.z))
    }
}

impl Emitter for Environment {
    fn bounds(&self) -> Cap {
        Cap { axis: DVec3::Z, radius_rad: PI }
    }

    fn margin(&self, _: DVec3) -> f64 {
        1.0
    }

    fn radiance(&self, wi: DVec3) -> DVec3 {
        Environment::radiance(self, wi)
    }

    fn grain_rad(&self) -> f64 {
        self.panorama.pixel_rad()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::direction;

    #[test]
    fn pixels_are_where_the_manual_says() {
        let (width, height) = (8, 4);
        let texels = (0..32).map(|i| [i as f32, 0.0, 1.0]).collect();
        let panorama = Arc::new(Panorama { width, height, texels });
        let around =
            |rotate_deg| Environment { panorama: Arc::clone(&panorama), scale: 2.0, rotate_deg };
        for (row, column) in [(0, 0), (1, 5), (2, 7), (3, 3)] {
            let (theta, phi) = ((row as f64 + 0.5) * 45.0, (column as f64 + 0.5) * 45.0 - 180.0);
            let expected = DVec3::new(2.0 * (row * 8 + column) as f64, 0.0, 2.0);
            for turned in [0.0, 30.0, -200.0] {
                let found = around(turned).radiance(direction(theta, phi + turned));
                assert!(found.distance(expected) < 1e-9, "{row} {column} {turned}: {found}");
            }
        }
        // half way between the last column and the first
        let seam = around(0.0).radiance(direction(67.5, 180.0));
        assert!((seam.x - 2.0 * 11.5).abs() < 1e-9, "{seam}");
        // beyond the first centre
        let pole = around(0.0).radiance(direction(1.0, 22.5 - 180.0));
        assert!(pole.x.abs() < 1e-9, "{pole}");
    }
}
