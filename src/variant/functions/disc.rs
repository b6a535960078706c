//! `diffraction_disc(axis, radius, wr)`: radiance under a cap of the sphere.

use std::f64::consts::FRAC_PI_2;

use crate::error::Result;
use crate::optics::direction;
use crate::plan::Optics;
use crate::surface::HeightField;
use crate::variant::{Cost, Form};

use super::lamps::{self, Place};
use super::{Arguments, ExactProbe, Function, FunctionKind, StatedError};

/// Light from a disc.
pub static DISC: Disc = Disc;

/// Light from a disc: `diffraction_disc(axis, radius, wr)`.
pub struct Disc;

/// Angular radii of probes, degrees: a small lamp, the sun, bulbs, softboxes, nearly a hemisphere.
const RADII_DEG: [f64; 8] = [0.05, 0.2665, 0.2665, 1.0, 5.0, 15.0, 40.0, 89.0];

/// Meaning of the arguments.
pub(super) const ARGUMENTS: &str = "axis: unit vector to the middle of the disc; radius: angular radius, 1e-4 to π/2 rad; wr: unit vector to the viewer; both point away from the surface";

/// Unit of the result.
pub(super) const UNIT: &str = "radiance under a disc of irradiance 1, perpendicular to its axis, relative to a white of radiance 1; a white diffuser that faces the disc shows 1/π";

/// 95th percentile of CIEDE2000 against the exact colours (0.33 on a DVD under a disc of 15° in radius).
const ERROR: f64 = 0.5;

impl Function for Disc {
    fn name(&self) -> &'static str {
        "diffraction_disc"
    }

    fn tristimulus_name(&self) -> &'static str {
        "tristimulus_disc"
    }

    fn signature(&self) -> &'static str {
        "(axis: vec3f, radius: f32, wr: vec3f) -> vec3f"
    }

    fn arguments(&self) -> &'static str {
        ARGUMENTS
    }

    fn kind(&self) -> FunctionKind {
        FunctionKind::Disc
    }

    fn unit(&self, _: &Form) -> &'static str {
        UNIT
    }

    fn cost(&self, form: &Form) -> Cost {
        cost(form, 1)
    }

    fn errors(&self, _: &Form) -> Vec<StatedError> {
        vec![StatedError { under: "any disc".to_owned(), de2000_p95: ERROR }]
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

/// Cost under a bulb and under the widest disc. `lights`: spectra whose moments are read at each end of a range, 1 for white light.
pub(super) fn cost(form: &Form, lights: u64) -> Cost {
    let disc = |radius_rad| {
        let axis = direction(20.0, 0.0);
        move |wr| Arguments::Disc { axis, radius_rad, colour: None, wr }
    };
    lamps::cost(form, lights, &disc(BULB_RAD), &disc(FRAC_PI_2))
}

/// A disc at a place.
pub(super) fn candidate(i: usize, Place { axis, near }: Place<'_>) -> Arguments {
    let radius_rad = RADII_DEG[i % RADII_DEG.len()].to_radians();
    Arguments::Disc { axis, radius_rad, colour: None, wr: near(0.7 * radius_rad.min(0.6)) }
}

/// Angular radius of the disc under which the mean cost is counted, rad. A grid of viewers would miss the sun.
const BULB_RAD: f64 = 5.0 / 180.0 * std::f64::consts::PI;
