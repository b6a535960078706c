//! An f64 rasteriser, which finds the visible point of each pixel. It tests the drivers and shares no code with them.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::variant::mesh::{MeshParams, MeshVertex, mesh_vert};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::mesh::Mesh;

/// The visible point at a pixel's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Index of the triangle.
    pub triangle: usize,
    /// Minimum of the corners' weights: 0 on an edge of the triangle.
    pub inside: f64,
    /// The interpolated output of the vertex stage there; `position` is in clip space.
    pub at: MeshVertex,
    /// The same of that triangle at the other pixel in the row and in the column of a block of 2 × 2, from which drivers take
    /// derivatives.
    pub next: [MeshVertex; 2],
}

/// The visible points of a picture of this size, `[row][column]` from the top; `None` outside the mesh.
///
/// The time is proportional to the pixels of all triangles' bounding boxes. Triangles that reach behind the camera are an error,
/// since nothing is clipped.
pub fn visible(
    mesh: &Mesh,
    params: &MeshParams,
    [width, height]: [u32; 2],
) -> Result<Vec<Option<Seen>>> {
    let corners: Vec<MeshVertex> =
        mesh.vertices.par_iter().map(|vertex| mesh_vert(params, vertex)).collect();
    let used = mesh.triangles.iter().flatten();
    if used.clone().any(|i| corners[*i as usize].position.w <= 0.0) {
        let cause = "reaches behind the camera, which the f64 picture does not support";
        return Err(Error::new(&mesh.name, cause).remedy("move the camera out"));
    }
    let pixel = |i: u32| {
        let position = corners[i as usize].position;
        let (x, y) = (position.x / position.w, position.y / position.w);
        DVec2::new(0.5 * (x + 1.0) * f64::from(width), 0.5 * (1.0 - y) * f64::from(height))
    };
    let mut seen: Vec<Option<Seen>> = vec![None; width as usize * height as usize];
    let mut depths = vec![f64::INFINITY; seen.len()];
    for (triangle, indices) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = indices.map(pixel);
        let area = (b - a).perp_dot(c - a);
        if area == 0.0 {
            continue;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |low: f64, high: f64, size: u32| {
            (low - 0.5).ceil().max(0.0) as i64
                ..=(high - 0.5).floor().min(f64::from(size) - 1.0) as i64
        };
        for row in range(low.y, high.y, height) {
            for column in range(low.x, high.x, width) {
                let weights = |column: i64, row: i64| {
                    let p = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                    DVec3::new(
                        (c - b).perp_dot(p - b) / area,
                        (a - c).perp_dot(p - c) / area,
                        (b - a).perp_dot(p - a) / area,
                    )
                };
                let inside = weights(column, row).min_element();
                if inside < 0.0 {
                    continue;
                }
                let of = |column, row| {
                    blend(indices.map(|i| &corners[i as usize]), weights(column, row))
                };
                let at = of(column, row);
                let place = row as usize * width as usize + column as usize;
                let depth = at.position.z / at.position.w;
                if (0.0..=1.0).contains(&depth) && depth < depths[place] {
                    depths[place] = depth;
                    let next = [of(column ^ 1, row), of(column, row ^ 1)];
                    seen[place] = Some(Seen { triangle, inside, at, next });
                }
            }
        }
    }
    Ok(seen)
}

/// Perspective-correct interpolation over a triangle: screen weights divided by `w`.
fn blend(corners: [&MeshVertex; 3], screen: DVec3) -> MeshVertex {
    let ws = DVec3::from(corners.map(|c| c.position.w));
    let weights = screen / ws / (screen / ws).element_sum();
    let [a, b, c] = corners;
    let [p, q, r] = weights.to_array();
    MeshVertex {
        position: p * a.position + q * b.position + r * c.position,
        place: p * a.place + q * b.place + r * c.place,
        normal: p * a.normal + q * b.normal + r * c.normal,
        tangent: p * a.tangent + q * b.tangent + r * c.tangent,
        uv: p * a.uv + q * b.uv + r * c.uv,
    }
}
