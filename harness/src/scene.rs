//! A scene to draw a variant in: meshes with tangents, an orbiting camera, directional lights, a body's colour.
//!
//! World: right-handed, `y` up in the picture; a camera at azimuth and elevation 0 stands on `+z`. Lengths have no unit.
//! Everything here is data or f64 arithmetic; drawing is [`crate::drivers::gpu`]'s and [`crate::scene::drawing`]'s.

mod camera;
pub mod drawing;
mod gltf;
mod mesh;
mod obj;
pub mod pattern;
pub mod tone_map;
pub mod raster;
mod raw;
mod read;
mod snake;
mod sphere;
mod tangents;

pub use camera::Orbit;
pub use mesh::Mesh;
pub use read::read;
pub use snake::{Snake, snake};
pub use sphere::sphere;

use glam::DVec3;

/// The lights of the figure "Different light directions" of the texts (5.16): directions that the light travels in, the
/// camera looking along `-z`.
///
/// The first is printed as (-3.3130, 0.0, -0.9999), which is no unit vector; -0.0130 is, to the digits given.
pub const PRINTED_LIGHTS: [[f64; 3]; 6] = [
    [-0.0130, 0.0, -0.9999],
    [-0.1989, 0.0, -0.9799],
    [-0.3897, 0.0, -0.9208],
    [0.0995, 0.0993, -0.9900],
    [0.0995, 0.2940, -0.9505],
    [0.0995, 0.4770, -0.8731],
];

/// The zooms of the figure "Different camera zoom levels" of the texts (5.15).
pub const PRINTED_ZOOMS: [f64; 6] = [0.1, 0.2, 0.5, 1.0, 1.5, 2.0];

/// A directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Direction to the light in the world, of any length.
    pub direction: DVec3,
    /// Radiance of a white diffuser that faces it, linear sRGB.
    pub colour: [f32; 3],
}

impl Light {
    /// White light from a direction.
    pub fn white(direction: DVec3) -> Light {
        Light { direction, colour: [1.0; 3] }
    }
}

/// Most lights of a picture.
pub const MAX_LIGHTS: usize = 4;
