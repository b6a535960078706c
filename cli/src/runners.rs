//! From flags to something that evaluates a variant on a surface.

use anyhow::{Result, bail};
use diffraction_shaders::input;
use diffraction_shaders::plan::{Plan, SurfaceSpec, Variant};
use diffraction_shaders::runner::{Exact, Placement, Runner, TwinRunner};
use diffraction_shaders::surface::{self, Surface};

use crate::args::{Runner as Kind, RunnerArgs, SurfaceArgs};
use crate::console::Console;

/// What opens a runner on a driver.
pub type Drivers = for<'a> fn(Placement<'a>, &RunnerArgs) -> Result<Box<dyn Runner + 'a>>;

/// That of a program that has no drivers.
pub fn none<'a>(_: Placement<'a>, args: &RunnerArgs) -> Result<Box<dyn Runner + 'a>> {
    bail!("--runner {:?}: this program has no drivers; {} has", args.runner, crate::harness::NAME)
}

/// Everything that an evaluation needs to know.
pub struct Job {
    /// The surface as planned.
    pub spec: SurfaceSpec,
    /// Its heights.
    pub surface: Surface,
    /// The variant, under the optics of the surface; for `exact` one that only carries those.
    pub variant: Variant,
}

impl Job {
    /// Reads plan and surface; checks that the pitch resolves the shortest wavelength that will be asked for.
    pub fn new(surface: &SurfaceArgs, runner: &RunnerArgs, console: &Console) -> Result<Job> {
        let plan: Plan = surface.plan.read(console)?;
        let spec = plan.surface(&surface.surface)?.clone();
        let plan = plan.on(&spec);
        let (variant, min_nm) = match runner.runner {
            // the reference integrates the whole visible range, whatever the variants do
            Kind::Exact => (Variant::texts(&plan.optics), 380.0),
            _ => {
                let variant = plan.variant(runner.variant.as_deref())?;
                let min_nm = variant.wavelengths.min_nm;
                (variant, min_nm)
            }
        };
        let surface = input::load_surface(&spec)?;
        surface.notes.iter().for_each(|note| console.note(note));
        surface.field.check_pitch(&surface::subject(&spec), min_nm)?;
        Ok(Job { spec, surface, variant })
    }

    /// The placement that runners evaluate.
    pub fn placement(&self) -> Placement<'_> {
        Placement {
            height: &self.surface.field,
            rotate_deg: self.spec.rotate_deg,
            variant: &self.variant,
        }
    }

    /// The runner that the flags name.
    pub fn runner(&self, args: &RunnerArgs, drivers: Drivers) -> Result<Box<dyn Runner + '_>> {
        let placement = self.placement();
        if args.unpacked && args.runner != Kind::Twin {
            bail!(
                "--unpacked: only the twin can read tables before they are rounded; use --runner twin"
            );
        }
        Ok(match args.runner {
            Kind::Exact => Box::new(Exact(placement)),
            Kind::Twin => Box::new(TwinRunner::new(placement, !args.unpacked)?),
            _ => drivers(placement, args)?,
        })
    }
}
