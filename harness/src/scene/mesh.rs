//! Meshes for drawing.

use diffraction_shaders::variant::mesh::{OrientationMap, Vertex};
use glam::{DMat4, DVec3};

use crate::drivers::ColourMap;

/// Triangles with tangent frames, the body's colour and an orientation field.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Name, for errors.
    pub name: String,
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// Vertex indices of the corners.
    pub triangles: Vec<[u32; 3]>,
    /// Transform from the mesh to the world.
    pub model: DMat4,
    /// Colour of the body.
    pub colour: ColourMap,
    /// Angles added to those of the vertices.
    pub orientation: OrientationMap,
    /// Notes for the user about what was repaired or left out when the file was read.
    pub notes: Vec<String>,
}

impl Mesh {
    /// A grey mesh of valid vertices, not transformed.
    pub fn new(name: &str, vertices: Vec<Vertex>, triangles: Vec<[u32; 3]>) -> Mesh {
        Mesh {
            name: name.to_owned(),
            vertices,
            triangles,
            model: DMat4::IDENTITY,
            colour: ColourMap::plain([128; 3]),
            orientation: OrientationMap::none(),
            notes: Vec::new(),
        }
    }

    /// Centre and half size of its bounding box in the world.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let places = self.vertices.iter().map(|v| self.model.transform_point3(v.position));
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = places.fold(start, |(low, high), p| (low.min(p), high.max(p)));
        if low.x > high.x {
            (DVec3::ZERO, DVec3::ONE)
        } else {
            ((low + high) / 2.0, (high - low) / 2.0)
        }
    }

    /// Whether a point of the world is inside a closed mesh: a ray towards `+x` crosses it an odd number of times.
    pub fn holds(&self, point: DVec3) -> bool {
        // a direction that is not along a modelled edge
        let ray = DVec3::new(0.883, 0.317, 0.347);
        let at = |i: u32| self.model.transform_point3(self.vertices[i as usize].position) - point;
        let hit = |t: &&[u32; 3]| {
            let [a, b, c] = t.map(at);
            let (ab, ac) = (b - a, c - a);
            let across = ray.cross(ac);
            let det = ab.dot(across);
            let (p, q) = (-a.dot(across) / det, ray.dot((-a).cross(ab)) / det);
            det != 0.0 && p >= 0.0 && q >= 0.0 && p + q < 1.0 && ac.dot((-a).cross(ab)) / det > 0.0
        };
        self.triangles.iter().filter(hit).count() % 2 == 1
    }
}
