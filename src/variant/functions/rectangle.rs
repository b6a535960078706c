//! `diffraction_rectangle(a, b, c, d, wr)`: radiance under a spherical quadrilateral.

use glam::DVec3;

use crate::error::Result;
use crate::optics::direction;
use crate::plan::Optics;
use crate::surface::HeightField;
use crate::variant::{Cost, Form};

use super::lamps::{self, Place};
use super::{Arguments, ExactProbe, Function, FunctionKind, StatedError};

/// Light from a quadrilateral.
pub static RECTANGLE: Rectangle = Rectangle;

/// Light from a spherical quadrilateral: `diffraction_rectangle(a, b, c, d, wr)`.
pub struct Rectangle;

/// 95th percentile of CIEDE2000 against the exact colours (0.30 on a DVD under 24 × 10°).
const ERROR: f64 = 0.5;

/// Widths and heights of probes, degrees: a tube, a window, softboxes, a wall.
const SIZES_DEG: [[f64; 2]; 5] =
    [[24.0, 10.0], [50.0, 30.0], [3.0, 2.0], [60.0, 1.0], [100.0, 80.0]];

impl Function for Rectangle {
    fn name(&self) -> &'static str {
        "diffraction_rectangle"
    }

    fn tristimulus_name(&self) -> &'static str {
        "tristimulus_rectangle"
    }

    fn signature(&self) -> &'static str {
        "(a: vec3f, b: vec3f, c: vec3f, d: vec3f, wr: vec3f) -> vec3f"
    }

    fn arguments(&self) -> &'static str {
        "a, b, c, d: unit vectors to the corners of a convex spherical quadrilateral within a hemisphere, in either order around it, neighbours may be the same; wr: unit vector to the viewer; all point away from the surface"
    }

    fn kind(&self) -> FunctionKind {
        FunctionKind::Rectangle
    }

    fn unit(&self, _: &Form) -> &'static str {
        "radiance under a quadrilateral of radiance 1, relative to a white of radiance 1"
    }

    fn cost(&self, form: &Form) -> Cost {
        cost(form, 1)
    }

    fn errors(&self, _: &Form) -> Vec<StatedError> {
        vec![StatedError { under: "any quadrilateral".to_owned(), de2000_p95: ERROR }]
    }

    fn probe_count(&self) -> usize {
        lamps::PROBES
    }

    fn probes(
        &self,
        height: &HeightField,
        rotate_deg: f64,
        optics: &Optics,
    ) -> Result<Vec<ExactProbe>> {
        lamps::probes(height, rotate_deg, optics, &candidate)
    }
}

/// Cost under a window and under the widest quadrilateral. `lights`: spectra whose moments are read at each end of a range, 1 for white light.
pub(super) fn cost(form: &Form, lights: u64) -> Cost {
    let [window, widest] = [[24.0, 10.0], [170.0, 170.0]].map(|size_deg| {
        let corners = corners(direction(20.0, 0.0), size_deg, 0.0);
        move |wr| Arguments::Rectangle { corners, colour: None, wr }
    });
    lamps::cost(form, lights, &window, &widest)
}

/// A quadrilateral at a place.
pub(super) fn candidate(i: usize, Place { axis, near }: Place<'_>) -> Arguments {
    let size_deg = SIZES_DEG[i % SIZES_DEG.len()];
    let mut corners = corners(axis, size_deg, 37.0 * i as f64);
    match i % 7 {
        // the other way round, a triangle, a corner at the normal
        1 => corners.reverse(),
        2 => corners[3] = corners[2],
        3 => {
            let turn = glam::DQuat::from_rotation_arc(corners[0], DVec3::Z);
            corners = corners.map(|corner| turn * corner);
        }
        _ => {}
    }
    let smallest = 0.5 * size_deg[0].min(size_deg[1]).to_radians();
    Arguments::Rectangle { corners, colour: None, wr: near(0.7 * smallest) }
}

/// Corners of a rectangle about an axis, turned about it.
fn corners(axis: DVec3, [width_deg, height_deg]: [f64; 2], turned_deg: f64) -> [DVec3; 4] {
    let (first, second) = axis.any_orthonormal_pair();
    let (sin, cos) = turned_deg.to_radians().sin_cos();
    let across = cos * first + sin * second;
    let up = axis.cross(across);
    let [x, y] = [width_deg, height_deg].map(|deg| (0.5 * deg).to_radians().tan());
    [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| (axis + x * across + y * up).normalize())
}
