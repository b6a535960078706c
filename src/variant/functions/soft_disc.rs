//! `diffraction_disc(axis, radius, wr)` of tables with wider lobes: the disc is a sum of lobes.

use crate::error::Result;
use crate::plan::Optics;
use crate::surface::HeightField;
use crate::tables::lobe_sigma;
use crate::variant::{Cost, DISC_LOBES, Form};

use super::disc::{ARGUMENTS, UNIT};
use super::lamps::{self, Place};
use super::{Arguments, DISC, ExactProbe, Function, FunctionKind, SPREAD, StatedError};

/// Light from a disc, as a sum of wider lobes.
pub static SOFT_DISC: SoftDisc = SoftDisc;

/// Light from a disc: `diffraction_disc(axis, radius, wr)` of tables with wider lobes.
pub struct SoftDisc;

/// Radii of probes, relative to the disc that is as wide as the narrowest lobes.
const RADII: [f64; 4] = [1.5, 3.0, 6.0, 12.0];
/// Largest radius of a probe, radians.
const LARGEST_RAD: f64 = 0.2;

impl Function for SoftDisc {
    fn name(&self) -> &'static str {
        DISC.name()
    }

    fn tristimulus_name(&self) -> &'static str {
        DISC.tristimulus_name()
    }

    fn signature(&self) -> &'static str {
        DISC.signature()
    }

    fn arguments(&self) -> &'static str {
        ARGUMENTS
    }

    fn kind(&self) -> FunctionKind {
        FunctionKind::Disc
    }

    fn probed(&self) -> &'static str {
        "diffraction_disc as a sum of lobes"
    }

    fn unit(&self, _: &Form) -> &'static str {
        UNIT
    }

    /// One spread for each lobe, and the texel with the reflectance at normal incidence. A narrow disc is one lobe.
    fn cost(&self, form: &Form) -> Cost {
        let one = SPREAD.cost(form);
        let lobes = DISC_LOBES as u64;
        let fetches = lobes * one.fetches + 1;
        Cost { fetches, fetches_mean: lobes as f64 * one.fetches_mean + 1.0, ..one }
    }

    fn errors(&self, form: &Form) -> Vec<StatedError> {
        let Form::Baked(form) = form else { return Vec::new() };
        form.disc_errors()
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
        let narrowest_rad = 2.0 * lobe_sigma(optics.into());
        let candidate = |i: usize, Place { axis, near }: Place<'_>| {
            let radius_rad = (RADII[i % RADII.len()] * narrowest_rad).min(LARGEST_RAD);
            Arguments::Disc { axis, radius_rad, colour: None, wr: near(0.7 * radius_rad) }
        };
        lamps::probes(height, rotate_deg, optics, &candidate)
    }
}
