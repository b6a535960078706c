//! `diffraction_path(wr, random)` with `diffraction_weight(wr, path)`: random paths for path tracers.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::error::Result;
use crate::field::orders::OrderSum;
use crate::light::{Lobe, Sky};
use crate::plan::Optics;
use crate::surface::HeightField;
use crate::tables::paths::{PATH_LEVELS, wavelength_cells};
use crate::variant::{Cost, Form, Pattern};

use super::environment::skies;
use super::lamps::{PROBES, part};
use super::{Arguments, ExactProbe, Function, FunctionKind};

/// Random paths.
pub static PATH: Paths = Paths;

/// Random paths: `diffraction_path(wr, random)`, and what belongs to it.
pub struct Paths;

impl Function for Paths {
    fn name(&self) -> &'static str {
        "diffraction_path"
    }

    fn tristimulus_name(&self) -> &'static str {
        "tristimulus_weight"
    }

    fn signature(&self) -> &'static str {
        "(wr: vec3f, random: vec3f) -> vec4f"
    }

    fn tristimulus_signature(&self) -> &'static str {
        WEIGHT
    }

    fn further(&self, form: Option<&Form>) -> &'static [(&'static str, &'static str)] {
        const ALL: &[(&str, &str)] = &[
            ("diffraction_weight", WEIGHT),
            ("diffraction_light", "(rgb: vec3f, lambda_um: f32) -> f32"),
        ];
        match form {
            Some(Form::Baked(_)) => &ALL[..1],
            _ => ALL,
        }
    }

    fn arguments(&self) -> &'static str {
        "wr: unit vector to the viewer, pointing away from the surface; random: three even random numbers, 0 to 1; path: what diffraction_path returned for the same viewer; rgb: radiance in linear sRGB from the direction of the path; lambda_um: w of the path"
    }

    fn kind(&self) -> FunctionKind {
        FunctionKind::Path
    }

    fn unit(&self, form: &Form) -> &'static str {
        match form {
            Form::Baked(_) => {
                "xyz: unit vector to the light, whose z is 0 where none comes; w: 0, for all wavelengths. The mean over many paths of diffraction_weight times the radiance from there is the radiance; coloured light is multiplied in RGB"
            }
            _ => {
                "xyz: unit vector to the light, whose z is 0 where none comes; w: wavelength, µm. The mean over many paths of diffraction_weight times diffraction_light of the radiance from there is the radiance"
            }
        }
    }

    /// Cost of a path with its weight.
    fn cost(&self, form: &Form) -> Cost {
        let own = form.cost();
        let fetches = match form {
            Form::Orders(orders) => {
                let halvings = (wavelength_cells(orders.sum.range_nm) as f64).log2().ceil() as u64;
                // the order; the wavelength; its light and the probabilities of both; the efficiency
                1 + halvings + 2 + 4 + 1
            }
            _ => 2 * u64::from(PATH_LEVELS) + own.fetches,
        };
        Cost {
            evaluations: 1,
            evaluations_mean: 1.0,
            term_fetches: 1,
            fetches,
            fetches_mean: fetches as f64,
            ..own
        }
    }

    fn probe_count(&self) -> usize {
        PROBES
    }

    /// The exact result is the radiance that the mean of all paths must have.
    fn probes(
        &self,
        height: &HeightField,
        rotate_deg: f64,
        optics: &Optics,
    ) -> Result<Vec<ExactProbe>> {
        let orders = OrderSum::new(height, rotate_deg, optics)?.for_skies();
        let probe = |i: usize| {
            // few viewers, since the sum over the orders of a scan is long
            let seen = i / VIEWS;
            let [lobe, _] = skies()[1 + seen % 3].lobes;
            let sky = Sky { constant: skies()[seen % 4].constant, lobes: [lobe, Lobe::default()] };
            let plane = 0.9 * part(seen, 1).sqrt() * DVec2::from_angle(TAU * part(seen, 2));
            let wr = plane.extend((1.0 - plane.length_squared()).sqrt());
            let random = DVec3::new(part(i, 3), part(i, 4), part(i, 5));
            Arguments::Path { sky, random, wr }.rounded()
        };
        let mut found: Vec<ExactProbe> = Vec::with_capacity(PROBES);
        for i in 0..PROBES {
            let arguments = probe(i);
            let known = found.last().filter(|last| last.arguments.wr() == arguments.wr());
            let xyz = match (known, arguments) {
                (None, Arguments::Path { sky, wr, .. }) => orders.radiance(&sky, wr),
                (known, _) => known.map_or([0.0; 3], |last| last.xyz),
            };
            found.push(ExactProbe { arguments, pattern: Pattern::NONE, xyz });
        }
        Ok(found)
    }
}

/// Arguments and result of the weight of a path.
const WEIGHT: &str = "(wr: vec3f, path: vec4f) -> vec3f";

/// Paths of a viewer.
const VIEWS: usize = 4;
