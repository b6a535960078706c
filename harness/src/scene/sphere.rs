//! A sphere whose tangents follow its parallels.

use std::f64::consts::{PI, TAU};

use diffraction_shaders::variant::mesh::Vertex;
use glam::{DVec2, DVec3};

use super::mesh::Mesh;

/// A sphere of radius 1 about the origin with its poles on `y`: `columns` meridians and half as many parallels.
///
/// Tangents point east, so bitangents point north. Texture coordinates run from west to east and from north to south.
pub fn sphere(columns: u32) -> Mesh {
    let rows = (columns / 2).max(2);
    let columns = columns.max(3);
    let vertex = |i: u32| {
        let (column, row) = (i % (columns + 1), i / (columns + 1));
        let uv = DVec2::new(f64::from(column), f64::from(row))
            / DVec2::new(f64::from(columns), f64::from(rows));
        let ((sin_l, cos_l), (sin_p, cos_p)) = ((TAU * uv.x).sin_cos(), (PI * uv.y).sin_cos());
        let normal = DVec3::new(sin_p * sin_l, cos_p, sin_p * cos_l);
        let tangent = DVec3::new(cos_l, 0.0, -sin_l).extend(1.0);
        Vertex { position: normal, normal, tangent, uv, orientation_angle: 0.0 }
    };
    let vertices = (0..(columns + 1) * (rows + 1)).map(vertex).collect();
    let cell = |i: u32| {
        let (column, row) = (i % columns, i / columns);
        let at = |x: u32, y: u32| (row + y) * (columns + 1) + column + x;
        [[at(0, 0), at(0, 1), at(1, 1)], [at(0, 0), at(1, 1), at(1, 0)]]
    };
    // the triangles at the poles that have no area are left out
    let triangles = (0..columns * rows).flat_map(cell).enumerate();
    let kept = triangles.filter(|(k, _)| {
        let (row, second) = (*k as u32 / 2 / columns, k % 2 == 1);
        !(row == 0 && second || row == rows - 1 && !second)
    });
    let triangles = kept.map(|(_, t)| t).collect();
    Mesh::new("sphere", vertices, triangles)
}
