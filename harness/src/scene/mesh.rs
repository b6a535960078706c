//! Meshes that can be drawn.

use diffraction_shaders::variant::mesh::{OrientationMap, Vertex};
use glam::{DMat4, DVec3};

use crate::drivers::ColourMap;

/// Triangles with tangent frames, a body's colour and an orientation field.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Names it in errors.
    pub name: String,
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// Indices of the corners.
    pub triangles: Vec<[u32; 3]>,
    /// From the mesh to the world.
    pub model: DMat4,
    /// Colour of the body.
    pub colour: ColourMap,
    /// Angles that are added to those of the vertices.
    pub orientation: OrientationMap,
    /// What was mended or left out when it was read, for the user.
    pub notes: Vec<String>,
}

impl Mesh {
    /// A mesh that needs no mending, grey, at its place.
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

    /// Centre and half of the box around it in the world.
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

    /// Whether a point of the world lies inside, for a mesh that is closed: a ray to `+x` leaves it an odd number of times.
    pub fn holds(&self, point: DVec3) -> bool {
        // a direction that no modelled edge lies along
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
