//! Generates tangents for files without tangents: MikkTSpace (M. Mikkelsen, 2008).

use std::collections::BTreeMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use diffraction_shaders::error::{Error, Result};
use glam::{DVec3, DVec4};

use super::mesh::Mesh;

/// Gives every corner of every triangle a tangent. Vertices whose corners disagree are split. Returns the number of corners
/// without a tangent from the texture coordinates: these get the axis that is farthest from their normal.
///
/// As in glTF, the bitangent points up in the texture, against `v`, so the algorithm gets `1 - v`.
pub(super) fn generate(mesh: &mut Mesh) -> Result<usize> {
    let mut corners = Corners { mesh, tangents: vec![None; 3 * mesh.triangles.len()] };
    generate_tangents(&mut corners)
        .map_err(|error| Error::new(&corners.mesh.name, error.to_string()))?;
    let tangents = corners.tangents;
    let mut known: BTreeMap<(u32, [u32; 4]), u32> = BTreeMap::new();
    let (mut vertices, mut frameless) = (Vec::new(), 0);
    let mut triangles = mesh.triangles.clone();
    for (corner, index) in triangles.iter_mut().flatten().enumerate() {
        let vertex = mesh.vertices[*index as usize];
        let tangent = tangents[corner].filter(|t| t[..3].iter().any(|c| *c != 0.0));
        frameless += usize::from(tangent.is_none());
        let tangent = tangent.unwrap_or_else(|| any_tangent(vertex.normal));
        *index = *known.entry((*index, tangent.map(f32::to_bits))).or_insert_with(|| {
            let tangent = DVec4::from(tangent.map(f64::from));
            vertices.push(diffraction_shaders::variant::mesh::Vertex { tangent, ..vertex });
            vertices.len() as u32 - 1
        });
    }
    mesh.vertices = vertices;
    mesh.triangles = triangles;
    Ok(frameless)
}

fn any_tangent(normal: DVec3) -> [f32; 4] {
    let axis = if normal.x.abs() < 0.7 { DVec3::X } else { DVec3::Y };
    let tangent = (axis - axis.dot(normal) * normal).normalize_or_zero().as_vec3();
    [tangent.x, tangent.y, tangent.z, 1.0]
}

struct Corners<'a> {
    mesh: &'a Mesh,
    tangents: Vec<Option<[f32; 4]>>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> &diffraction_shaders::variant::mesh::Vertex {
        &self.mesh.vertices[self.mesh.triangles[face][corner] as usize]
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.vertex(face, corner).position.as_vec3().into()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.vertex(face, corner).normal.as_vec3().into()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.vertex(face, corner).uv.as_vec2();
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        self.tangents[3 * face + corner] = tangent.map(|t| t.tangent_encoded());
    }
}
