//! Scenes to draw a variant in: meshes with tangents, an orbiting camera, lights, a body's colour.
//!
//! World: right-handed, `y` up. A camera at azimuth and elevation 0 is on `+z`. Lengths have no unit. Everything here is data or
//! f64 arithmetic; [`crate::drivers::gpu`] and [`crate::scene::drawing`] draw.

mod camera;
mod card;
pub mod drawing;
pub mod flicker;
mod gltf;
pub mod lights;
pub mod markings;
mod mesh;
mod named;
mod obj;
pub mod tone_map;
pub mod raster;
mod raw;
mod read;
mod snake;
mod sphere;
pub mod surroundings;
mod tangents;
mod torus_knot;

pub use camera::Orbit;
pub use card::card;
pub use mesh::Mesh;
pub use read::read;
pub use snake::{Snake, snake};
pub use sphere::sphere;
pub use torus_knot::torus_knot;

/// The lights of the thesis's figure 5.16, "Different light directions": directions in which the light travels. The camera looks
/// along `-z`.
///
/// The first is printed as (-3.3130, 0.0, -0.9999), which is not a unit vector. With -0.0130 it is one, to the given digits.
pub const PRINTED_LIGHTS: [[f64; 3]; 6] = [
    [-0.0130, 0.0, -0.9999],
    [-0.1989, 0.0, -0.9799],
    [-0.3897, 0.0, -0.9208],
    [0.0995, 0.0993, -0.9900],
    [0.0995, 0.2940, -0.9505],
    [0.0995, 0.4770, -0.8731],
];

/// The zooms of the thesis's figure 5.15, "Different camera zoom levels".
pub const PRINTED_ZOOMS: [f64; 6] = [0.1, 0.2, 0.5, 1.0, 1.5, 2.0];
