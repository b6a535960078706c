//! `diffraction_environment(wr)`: radiance under surroundings.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::defines::Defines;
use crate::error::{Error, Result};
use crate::field::orders::OrderSum;
use crate::light::environment::filtered;
use crate::light::{Lobe, Sky};
use crate::optics::{Matter, direction};
use crate::plan::Optics;
use crate::surface::HeightField;
use crate::variant::bound::environment_error;
use crate::variant::cost::mean_and_worst_views;
use crate::variant::{Cost, Form, Pattern};

use super::lamps::{CANDIDATES, PROBES, part, viewer};
use super::{Arguments, Around, ExactProbe, Function, FunctionKind, StatedError};

/// Light from all around.
pub static ENVIRONMENT: Environment = Environment;

/// Light from all around: `diffraction_environment(wr)`.
pub struct Environment;

/// Standard deviation of lobes, radians, below which probes look at them through an order.
const NARROW_RAD: f64 = 0.05;

/// The skies of probes: constant and white; a red and a blue lobe; a bright small one in a dim sky; wide ones near the horizon.
pub fn skies() -> [Sky; 4] {
    let lobe = |theta, phi, sigma_rad, radiance| Lobe {
        axis: direction(theta, phi),
        sigma_rad,
        radiance: DVec3::from(radiance),
    };
    let sky = |constant, lobes| Sky { constant: DVec3::from(constant), lobes };
    let none = Lobe::default();
    [
        sky([1.0, 1.0, 1.0], [none, none]),
        sky(
            [0.05, 0.05, 0.05],
            [lobe(25.0, 40.0, 0.25, [2.0, 0.1, 0.1]), lobe(50.0, 200.0, 0.3, [0.1, 0.3, 2.0])],
        ),
        sky([0.1, 0.1, 0.12], [lobe(35.0, 250.0, 0.03, [20.0, 18.0, 12.0]), none]),
        sky(
            [0.3, 0.5, 1.0],
            [lobe(80.0, 90.0, 0.5, [3.0, 2.0, 1.0]), lobe(70.0, 310.0, 0.4, [0.5, 2.0, 0.5])],
        ),
    ]
}

/// The constants of surroundings in whole shaders.
pub fn define_surroundings(into: &mut Defines) {
    let rows = "number of rows of the two finest levels of the surroundings";
    into.count("ENVIRONMENT_ROWS", filtered::ROWS, rows);
    let levels = "number of levels of the surroundings";
    into.count("ENVIRONMENT_LEVELS", filtered::LEVELS, levels);
    let height = "number of rows of all levels with their frames";
    into.count("ENVIRONMENT_HEIGHT", filtered::HEIGHT, height);
    let spread = "blur of the second level, radians: 1.5 times the angle between its rows";
    into.number("FIRST_SPREAD", filtered::FIRST_SPREAD_RAD, spread);
}

impl Function for Environment {
    fn name(&self) -> &'static str {
        "diffraction_environment"
    }

    fn tristimulus_name(&self) -> &'static str {
        "tristimulus_environment"
    }

    fn signature(&self) -> &'static str {
        "(wr: vec3f) -> vec3f"
    }

    fn arguments(&self) -> &'static str {
        "wr: unit vector to the viewer, pointing away from the surface"
    }

    fn host(&self) -> Option<&'static str> {
        Some(
            "environment_radiance(direction: vec3f, spread: f32) -> vec3f: radiance of the surroundings, linear sRGB, from a unit direction in the tangent frame, blurred to a standard deviation of `spread` radians on each axis: 0, or up to about 0.5, more at grazing angles",
        )
    }

    fn kind(&self) -> FunctionKind {
        FunctionKind::Environment
    }

    fn unit(&self, _: &Form) -> &'static str {
        "radiance, in the unit of environment_radiance; a white is as bright as its surroundings"
    }

    /// A look-up of the surroundings counts as the evaluation. Beside it there is one of the efficiencies and three of the streaks;
    /// or a cell, with three colours on two layers. All cells count, though about half are below the horizon.
    fn cost(&self, form: &Form) -> Cost {
        let bytes = form.cost().table_bytes;
        match form {
            Form::Orders(orders) => {
                let (mean, worst) = mean_and_worst_views(|wr| 1 + orders.streak_lookups(wr));
                Cost::of_evaluations((mean, worst), 2, 3, bytes)
            }
            Form::Baked(baked) => {
                let count = baked.cells.map_or(0, |cells| u64::from(cells.count));
                Cost::of_evaluations((count as f64, count), 0, 7, bytes)
            }
            _ => Cost::default(),
        }
    }

    fn errors(&self, form: &Form) -> Vec<StatedError> {
        let error = match form {
            Form::Orders(orders) => Some(environment_error(orders.nodes)),
            Form::Baked(baked) => baked.sky_error(),
            _ => None,
        };
        let stated = |de2000_p95| StatedError {
            under: "surroundings without lamps narrower than 5°, which are discs".to_owned(),
            de2000_p95,
        };
        error.map(stated).into_iter().collect()
    }

    fn probe_count(&self) -> usize {
        PROBES
    }

    fn probes(
        &self,
        height: &HeightField,
        rotate_deg: f64,
        optics: &Optics,
    ) -> Result<Vec<ExactProbe>> {
        let normal = Matter::new(optics)?.normal_reflectance();
        let orders = OrderSum::new(height, rotate_deg, optics)?;
        let mut found = Vec::with_capacity(PROBES);
        for i in 0..CANDIDATES {
            let sky = skies()[i % 4];
            let [lobe, _] = sky.lobes;
            let wr = if lobe.sigma_rad < NARROW_RAD {
                // where an order shows the lobe, so that its blur counts
                viewer(height, rotate_deg, i, lobe.axis, 2.0 * lobe.sigma_rad)
            } else {
                let plane = 0.98 * part(i, 1).sqrt() * DVec2::from_angle(TAU * part(i, 2));
                plane.extend((1.0 - plane.length_squared()).sqrt())
            };
            // at grazing angles a rounded direction is another one
            if wr.z <= 0.1 {
                continue;
            }
            let arguments = Arguments::Environment { around: Around::Sky(sky), wr }.rounded();
            let xyz = orders.radiance(&sky, arguments.wr());
            if xyz[1] > 1e-3 * normal * sky.brightest() {
                found.push(ExactProbe { arguments, pattern: Pattern::NONE, xyz });
                if found.len() == PROBES {
                    return Ok(found);
                }
            }
        }
        let cause = format!("only {} of {PROBES} probes are lit", found.len());
        Err(Error::new("probe.json", cause))
    }
}
