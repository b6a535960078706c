//! Meshes that can be drawn: read from files, checked and mended.

use std::path::Path;

use diffraction_shaders::error::{Error, Result, Stage};
use diffraction_shaders::variant::mesh::{OrientationMap, Vertex};
use glam::{DMat4, DVec2, DVec3, DVec4};

use super::{ColourMap, gltf, obj, tangents};

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

/// What a file holds, before it is checked. Lists are as long as `positions`.
pub(super) struct Raw {
    pub positions: Vec<DVec3>,
    pub normals: Option<Vec<DVec3>>,
    pub tangents: Option<Vec<DVec4>>,
    /// (0, 0) is the first texel's corner.
    pub uvs: Option<Vec<DVec2>>,
    pub angles: Option<Vec<f64>>,
    pub triangles: Vec<[u32; 3]>,
    pub colour: ColourMap,
    pub notes: Vec<String>,
}

/// Reads a mesh from a `.gltf`, `.glb` or `.obj` file.
pub fn read(path: &Path) -> Result<Mesh> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let raw = match extension.to_ascii_lowercase().as_str() {
        "gltf" | "glb" => gltf::read(path)?,
        "obj" => obj::read(path)?,
        _ => {
            let cause = "its name ends in none of .gltf, .glb, .obj";
            return Err(Error::new(Stage::Run, path.display(), cause).remedy("convert it"));
        }
    };
    raw.mend(&path.display().to_string())
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

impl Raw {
    /// Refuses what has no meaning, replaces what is missing or no number, and says so.
    fn mend(mut self, name: &str) -> Result<Mesh> {
        let fail = |cause: String| Err(Error::new(Stage::Run, name, cause));
        if let Some(at) = self.positions.iter().position(|p| !p.is_finite()) {
            return fail(format!("vertex {at} has no place: {}", self.positions[at]));
        }
        let count = self.positions.len();
        if let Some(bad) = self.triangles.iter().flatten().find(|i| **i as usize >= count) {
            return fail(format!("a triangle names vertex {bad} of {count}"));
        }
        let before = self.triangles.len();
        let positions = &self.positions;
        self.triangles.retain(|t| normal_of(positions, t).length_squared() > 0.0);
        let mut notes = std::mem::take(&mut self.notes);
        let mut note = |count: usize, what: &str| {
            if count > 0 {
                notes.push(format!("{name}: {count} {what}"));
            }
        };
        note(before - self.triangles.len(), "triangles without area left out");
        if self.triangles.is_empty() {
            return fail("holds no triangle with an area".into());
        }
        let normals = self.mended_normals(&mut note);
        let mut uvs = self.uvs.take().unwrap_or_else(|| vec![DVec2::NAN; count]);
        let bad = uvs.iter_mut().filter(|uv| !uv.is_finite());
        let bad = bad.map(|uv| *uv = DVec2::ZERO).count();
        note(bad, "vertices have no texture coordinates; taken as 0");
        let mut angles = self.angles.take().unwrap_or_else(|| vec![0.0; count]);
        let lost = angles.iter_mut().filter(|a| !a.is_finite()).map(|a| *a = 0.0).count();
        note(lost, "orientation angles are no numbers; taken as 0");
        let given = self.tangents.take().unwrap_or_default();
        let is_frame =
            |t: &DVec4| t.is_finite() && t.truncate().length_squared() > 0.0 && t.w != 0.0;
        let missing = count - given.iter().filter(|t| is_frame(t)).count();
        let vertex = |i: usize| Vertex {
            position: self.positions[i],
            normal: normals[i],
            tangent: given
                .get(i)
                .filter(|_| missing == 0)
                .map_or(DVec4::W, |t| t.truncate().normalize().extend(t.w.signum())),
            uv: uvs[i],
            orientation_angle: angles[i],
        };
        let mut mesh = Mesh::new(name, (0..count).map(vertex).collect(), self.triangles);
        mesh.colour = self.colour;
        if missing > 0 {
            note(missing, "vertices have no tangent; all tangents generated by MikkTSpace");
            let frameless = tangents::generate(&mut mesh)?;
            note(
                frameless,
                "corners got no tangent from their texture coordinates; an arbitrary one taken",
            );
        }
        mesh.notes = notes;
        Ok(mesh)
    }

    /// Those given; where one is missing, zero or no number, the mean of the triangles around, by area.
    fn mended_normals(&mut self, note: &mut impl FnMut(usize, &str)) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for t in &self.triangles {
            let normal = normal_of(&self.positions, t);
            t.iter().for_each(|i| sums[*i as usize] += normal);
        }
        let given = self.normals.take().unwrap_or_default();
        let mut missing = 0;
        let normals = sums.iter().enumerate().map(|(i, sum)| {
            let given = given.get(i).and_then(|n| n.try_normalize());
            missing += usize::from(given.is_none());
            given.unwrap_or_else(|| sum.normalize_or_zero())
        });
        let normals = normals.collect();
        note(missing, "normals are missing or no numbers; taken from the triangles around");
        normals
    }
}

/// Normal of a triangle, as long as twice its area.
fn normal_of(positions: &[DVec3], triangle: &[u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|i| positions[i as usize]);
    (b - a).cross(c - a)
}
