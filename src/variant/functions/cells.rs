//! `diffraction_environment(wr)` of tables with wider lobes: the surroundings light cells of `(u, v)`.

use crate::error::Result;
use crate::plan::Optics;
use crate::surface::HeightField;
use crate::variant::{Cost, Form};

use super::environment::{ENVIRONMENT, probes};
use super::lamps::PROBES;
use super::{ExactProbe, Function, FunctionKind, StatedError};

/// Light from all around, on many orders.
pub static CELLS: CellSum = CellSum;

/// Light from all around, on many orders: `diffraction_environment(wr)` of tables with wider lobes.
pub struct CellSum;

impl Function for CellSum {
    fn name(&self) -> &'static str {
        ENVIRONMENT.name()
    }

    fn tristimulus_name(&self) -> &'static str {
        ENVIRONMENT.tristimulus_name()
    }

    fn signature(&self) -> &'static str {
        ENVIRONMENT.signature()
    }

    fn arguments(&self) -> &'static str {
        ENVIRONMENT.arguments()
    }

    fn host(&self) -> Option<&'static str> {
        Some(
            "environment_radiance(direction: vec3f, spread: f32) -> vec3f: radiance of the surroundings, linear sRGB, from a unit direction in the tangent frame, blurred to a standard deviation of `spread` radians on each axis; it is called once for each cell above the horizon, mostly with a spread of 0.02 to 0.2, more at grazing angles",
        )
    }

    fn kind(&self) -> FunctionKind {
        FunctionKind::Environment
    }

    fn probed(&self) -> &'static str {
        "diffraction_environment by cells"
    }

    fn unit(&self, form: &Form) -> &'static str {
        ENVIRONMENT.unit(form)
    }

    /// A look-up of the surroundings counts as the evaluation; beside it there are the cell and two layers of three colours. All
    /// cells count, though about half are below the horizon.
    fn cost(&self, form: &Form) -> Cost {
        let Form::Baked(baked) = form else { return Cost::default() };
        let count = baked.cells.map_or(0, |cells| u64::from(cells.count));
        Cost::of_evaluations((count as f64, count), 0, 8, form.cost().table_bytes)
    }

    fn errors(&self, form: &Form) -> Vec<StatedError> {
        let Form::Baked(baked) = form else { return Vec::new() };
        let of = |error| StatedError {
            under: "surroundings without lamps narrower than 5°, which are discs".to_owned(),
            de2000_p95: error,
        };
        baked.sky_error().map(of).into_iter().collect()
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
        probes(height, rotate_deg, optics)
    }
}
