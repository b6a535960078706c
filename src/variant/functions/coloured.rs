//! `diffraction_disc_coloured` and `diffraction_rectangle_coloured`: the functions of lamps for lamps of any colour.

use glam::DVec3;

use crate::error::Result;
use crate::plan::Optics;
use crate::surface::HeightField;
use crate::variant::{Cost, Form};

use super::lamps::{self, Place};
use super::{Arguments, ExactProbe, Function, FunctionKind, StatedError, disc, rectangle};

/// A disc of a colour.
pub static DISC_COLOURED: Coloured = Coloured {
    name: "diffraction_disc_coloured",
    tristimulus_name: "tristimulus_disc_coloured",
    signature: "(axis: vec3f, radius: f32, colour: vec3f, wr: vec3f) -> vec3f",
    arguments: "axis: unit vector to the middle of the disc; radius: angular radius, 1e-4 to π/2 rad; colour: irradiance of the disc, perpendicular to its axis, linear sRGB, nowhere negative; wr: unit vector to the viewer; axis and wr point away from the surface",
    unit: "radiance under a disc of that irradiance, relative to a white of radiance 1; under white, [1, 1, 1], a white diffuser that faces the disc shows 1/π",
    kind: FunctionKind::DiscColoured,
    white: FunctionKind::Disc,
    cost: disc::cost,
    candidate: disc::candidate,
};

/// A spherical quadrilateral of a colour.
pub static RECTANGLE_COLOURED: Coloured = Coloured {
    name: "diffraction_rectangle_coloured",
    tristimulus_name: "tristimulus_rectangle_coloured",
    signature: "(a: vec3f, b: vec3f, c: vec3f, d: vec3f, colour: vec3f, wr: vec3f) -> vec3f",
    arguments: "a, b, c, d: unit vectors to the corners of a convex spherical quadrilateral within a hemisphere, in either order around it, neighbours may be the same; colour: its radiance, linear sRGB, nowhere negative; wr: unit vector to the viewer; all but the colour point away from the surface",
    unit: "radiance under a quadrilateral of that radiance, relative to a white of radiance 1",
    kind: FunctionKind::RectangleColoured,
    white: FunctionKind::Rectangle,
    cost: rectangle::cost,
    candidate: rectangle::candidate,
};

/// The function of a lamp of any colour. The lamp's spectrum is that of white light, weighted by the shares that its colour has of the
/// primaries. A lamp behind a filter is no white lamp seen through the filter: an order brings few wavelengths, of which the filter
/// passes all or none.
pub struct Coloured {
    name: &'static str,
    tristimulus_name: &'static str,
    signature: &'static str,
    arguments: &'static str,
    unit: &'static str,
    kind: FunctionKind,
    /// The function of a white lamp of this shape.
    white: FunctionKind,
    /// Its cost, with the number of spectra whose moments are read at each end of a range of wavelengths.
    cost: fn(&Form, u64) -> Cost,
    /// A white lamp at a place.
    candidate: fn(usize, Place<'_>) -> Arguments,
}

/// Lights of which the table has moments: white, and its red and green shares.
const LIGHTS: u64 = 3;

/// Colours of probes: a bulb, dusk, neon red, signal green, a blue without red, white.
const COLOURS: [[f64; 3]; 7] = [
    [1.0, 0.6, 0.25],
    [0.4, 0.5, 1.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.1],
    [0.0, 0.2, 2.0],
    [1.0, 1.0, 1.0],
    [0.0, 0.0, 1.0],
];

impl Function for Coloured {
    fn name(&self) -> &'static str {
        self.name
    }

    fn tristimulus_name(&self) -> &'static str {
        self.tristimulus_name
    }

    fn signature(&self) -> &'static str {
        self.signature
    }

    fn arguments(&self) -> &'static str {
        self.arguments
    }

    fn kind(&self) -> FunctionKind {
        self.kind
    }

    fn unit(&self, _: &Form) -> &'static str {
        self.unit
    }

    fn cost(&self, form: &Form) -> Cost {
        (self.cost)(form, LIGHTS)
    }

    /// Those of a white lamp: the cubics that err are those of the orders, whatever the light.
    fn errors(&self, form: &Form) -> Vec<StatedError> {
        self.white.function().errors(form)
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
        let candidate = |i: usize, place: Place<'_>| {
            (self.candidate)(i, place).coloured(DVec3::from(COLOURS[i % COLOURS.len()]))
        };
        lamps::probes(height, rotate_deg, optics, &candidate)
    }
}
