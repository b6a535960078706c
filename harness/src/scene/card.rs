//! A card of paper, to put a foil on.

use diffraction_shaders::variant::mesh::Vertex;
use glam::{DVec2, DVec3};

use super::mesh::Mesh;
use crate::drivers::ColourMap;

/// Width of the card; its height is 1. A card of ISO/IEC 7810 is 85.60 mm × 53.98 mm.
const WIDTH: f64 = 85.60 / 53.98;
/// Colour of its paper, 8 bits sRGB.
const PAPER: [u8; 3] = [214, 209, 198];

/// A flat card that faces `+z`. Texture coordinates cover it once, with (0, 0) at the upper left; tangents point to the right.
pub fn card() -> Mesh {
    let vertex = |uv: DVec2| Vertex {
        position: DVec3::new((uv.x - 0.5) * WIDTH, 0.5 - uv.y, 0.0),
        normal: DVec3::Z,
        tangent: DVec3::X.extend(1.0),
        uv,
        orientation_angle: 0.0,
    };
    let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    let vertices = corners.map(vertex).to_vec();
    Mesh {
        colour: ColourMap::plain(PAPER),
        ..Mesh::new("card", vertices, vec![[0, 3, 2], [0, 2, 1]])
    }
}
