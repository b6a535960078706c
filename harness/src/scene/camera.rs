//! A camera that orbits a mesh.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::variant::mesh::MeshParams;
use glam::{DVec3, dcamera};

use super::mesh::Mesh;

/// Vertical field of view of a camera that shows a whole mesh, degrees.
const VIEW_DEG: f64 = 30.0;

/// A perspective camera on a sphere around a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// The point that it looks at.
    pub target: DVec3,
    /// Distance from the target at zoom 1.
    pub distance: f64,
    /// Angle about `y`, degrees, from `+z` towards `+x`.
    pub azimuth_deg: f64,
    /// Angle above the plane of `x` and `z`, degrees.
    pub elevation_deg: f64,
    /// Vertical field of view, degrees.
    pub view_deg: f64,
    /// Zoom: the distance is divided by this.
    pub zoom: f64,
}

impl Orbit {
    /// A camera on `+z` that shows a whole mesh in a picture of this shape (width over height).
    pub fn around(mesh: &Mesh, shape: f64) -> Orbit {
        let (centre, half) = mesh.bounds();
        let slope = (0.5 * VIEW_DEG.to_radians()).tan();
        let distance = half.z + 1.05 * half.y.max(half.x / shape) / slope;
        Orbit {
            target: centre,
            distance,
            azimuth_deg: 0.0,
            elevation_deg: 0.0,
            view_deg: VIEW_DEG,
            zoom: 1.0,
        }
    }

    /// Like [`Orbit::around`], far enough away for every azimuth.
    pub fn all_round(mesh: &Mesh, shape: f64) -> Orbit {
        let (_, half) = mesh.bounds();
        let across = half.x.hypot(half.z);
        let slope = (0.5 * VIEW_DEG.to_radians()).tan();
        let distance = across + 1.05 * half.y.max(across / shape) / slope;
        Orbit { distance, ..Orbit::around(mesh, shape) }
    }

    /// Position of the camera.
    pub fn eye(&self) -> DVec3 {
        let ((sin_a, cos_a), (sin_e, cos_e)) =
            (self.azimuth_deg.to_radians().sin_cos(), self.elevation_deg.to_radians().sin_cos());
        self.target + self.distance / self.zoom * DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e)
    }

    /// The uniform block for a picture of this size and a light.
    pub fn params(
        &self,
        mesh: &Mesh,
        [width, height]: [u32; 2],
        light: DVec3,
    ) -> Result<MeshParams> {
        let fail = |cause: String| Err(Error::new("camera", cause));
        if width == 0 || height == 0 {
            return fail(format!("a picture of {width} × {height} pixels is empty"));
        }
        if !(self.zoom > 0.0 && self.zoom.is_finite()) {
            return fail(format!("zoom {} must be above 0", self.zoom));
        }
        if !(self.distance > 0.0 && self.distance.is_finite()) {
            return fail(format!("distance {} must be above 0", self.distance));
        }
        if self.elevation_deg.abs() >= 90.0 {
            return fail(format!("elevation {}° must be between -90° and 90°", self.elevation_deg));
        }
        let eye = self.eye();
        let (centre, half) = mesh.bounds();
        let (away, radius) = (eye.distance(centre), half.length().max(1e-9));
        let (near, far) = ((away - radius).max(1e-3 * radius), away + radius);
        let shape = f64::from(width) / f64::from(height);
        Ok(MeshParams {
            model: mesh.model,
            view: dcamera::rh::view::look_at_mat4(eye, self.target, DVec3::Y),
            projection: dcamera::rh::proj::directx::perspective(
                self.view_deg.to_radians(),
                shape,
                near,
                far,
            ),
            light_direction: light,
            eye,
        })
    }
}
