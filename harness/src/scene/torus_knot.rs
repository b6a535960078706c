//! A torus knot: all directions of the normal, many curvatures.

use std::f64::consts::TAU;

use diffraction_shaders::variant::mesh::Vertex;
use glam::{DVec2, DVec3};

use super::mesh::Mesh;

/// Turns about the axis of the torus, and around its tube.
const TURNS: [f64; 2] = [2.0, 3.0];
/// Radius of the tube of the knot.
const RADIUS: f64 = 0.4;

/// The knot of the torus with 2 turns about `z` and 3 around its tube, as wide as three.js's with radius 1: `rings` rings of `sides`
/// vertices.
///
/// Tangents follow the knot. Texture coordinates run along it and around its tube.
pub fn torus_knot(rings: u32, sides: u32) -> Mesh {
    let (rings, sides) = (rings.max(3), sides.max(3));
    let vertex = |i: u32| {
        let (ring, side) = (i / (sides + 1), i % (sides + 1));
        let uv = DVec2::new(f64::from(ring), f64::from(side))
            / DVec2::new(f64::from(rings), f64::from(sides));
        let at = |uv: DVec2| surface(uv.x, uv.y);
        let step = 1e-5;
        let along = at(uv + step * DVec2::X).0 - at(uv - step * DVec2::X).0;
        let across = at(uv + step * DVec2::Y).0 - at(uv - step * DVec2::Y).0;
        let (position, outward) = at(uv);
        let normal = along.cross(across).normalize();
        let normal = normal * normal.dot(outward).signum();
        let tangent = (along - along.dot(normal) * normal).normalize();
        Vertex { position, normal, tangent: tangent.extend(1.0), uv, orientation_angle: 0.0 }
    };
    let vertices = (0..(rings + 1) * (sides + 1)).map(vertex).collect();
    let cell = |i: u32| {
        let (ring, side) = (i / sides, i % sides);
        let at = |x: u32, y: u32| (ring + x) * (sides + 1) + side + y;
        [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]]
    };
    Mesh::new("torus-knot", vertices, (0..rings * sides).flat_map(cell).collect())
}

/// A point of the tube and the direction to it from the middle of the tube.
fn surface(along: f64, around: f64) -> (DVec3, DVec3) {
    let (here, ahead) = (line(along), line(along + 1e-3));
    // a frame that closes: the sum of two points of the line is nearly a normal of it
    let forward = ahead - here;
    let side = forward.cross(ahead + here).normalize();
    let up = side.cross(forward).normalize();
    let (sin, cos) = (TAU * around).sin_cos();
    let outward = cos * up + sin * side;
    (here + RADIUS * outward, outward)
}

/// The line of the knot, 0 to 1 for all its turns.
fn line(along: f64) -> DVec3 {
    let [(sin_a, cos_a), (sin_b, cos_b)] = TURNS.map(|turns| (turns * TAU * along).sin_cos());
    0.5 * DVec3::new((2.0 + cos_b) * cos_a, (2.0 + cos_b) * sin_a, sin_b)
}
