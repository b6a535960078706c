//! A camera that orbits a mesh.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::variant::mesh::MeshParams;
use glam::{DVec3, dcamera};

use super::mesh::Mesh;

/// Vertical field of view of a camera that shows a whole mesh, degrees.
const VIEW_DEG: f64 = 30.0;

/// Size of a mesh in pixels at which a camera that recedes stops.
const FAR_PIXELS: f64 = 10.0;

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

    /// The same camera `count` times, from here away until the mesh is 10 pixels wide or high, whichever is more. Distances
    /// grow by equal factors. It is an error if the mesh is smaller from the beginning.
    pub fn receding(&self, mesh: &Mesh, [_, height]: [u32; 2], count: u32) -> Result<Vec<Orbit>> {
        let (_, half) = mesh.bounds();
        let slope = (0.5 * self.view_deg.to_radians()).tan();
        let pixels = f64::from(height) * half.x.max(half.y) / (slope * self.distance);
        let last = FAR_PIXELS / pixels;
        if last >= self.zoom {
            let cause =
                format!("the body is less than {FAR_PIXELS} pixels wide at zoom {}", self.zoom);
            return Err(Error::new("camera", cause).remedy("raise --zoom or --size"));
        }
        let steps = f64::from(count.max(2) - 1);
        let zoom = |i: u32| self.zoom * (last / self.zoom).powf(f64::from(i) / steps);
        Ok((0..count).map(|i| Orbit { zoom: zoom(i), ..*self }).collect())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::sphere::sphere;

    #[test]
    fn a_receding_camera_ends_where_the_body_is_ten_pixels_wide() {
        let mesh = sphere(32);
        let orbit = Orbit { zoom: 2.0, ..Orbit::around(&mesh, 1.0) };
        let all = orbit.receding(&mesh, [300, 300], 5).expect("recedes");
        assert_eq!((all.len(), all[0]), (5, orbit));
        let ratio = all[1].zoom / all[0].zoom;
        assert!((all[4].zoom / all[3].zoom - ratio).abs() < 1e-12);
        let [centre, side] = [DVec3::ZERO, DVec3::X].map(|place| {
            let params = all[4].params(&mesh, [300, 300], DVec3::Z).expect("valid");
            let clip = params.projection * params.view * (mesh.bounds().0 + place).extend(1.0);
            150.0 * clip.x / clip.w
        });
        let width = 2.0 * (side - centre).abs() * mesh.bounds().1.x;
        assert!((width - 10.0).abs() < 0.2, "{width}");
        assert!(orbit.receding(&mesh, [4, 4], 5).is_err());
    }
}
