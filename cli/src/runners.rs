//! From options to a runner, which evaluates a variant on a surface.

use anyhow::{Result, bail};
use diffraction_shaders::field::reference::{Reference, Span};
use diffraction_shaders::input;
use diffraction_shaders::plan::{Plan, SurfaceSpec, Variant};
use diffraction_shaders::runner::{Exact, Placement, Runner, TwinRunner};
use diffraction_shaders::surface::{self, Surface};

use crate::args::{Runner as Kind, RunnerArgs, SurfaceArgs};
use crate::console::Console;
use crate::memory::{self, MemoryArgs};

/// Opens a runner on a driver.
pub type Drivers = for<'a> fn(Placement<'a>, &RunnerArgs) -> Result<Box<dyn Runner + 'a>>;

/// The [`Drivers`] of a program without drivers: always an error.
pub fn none<'a>(_: Placement<'a>, args: &RunnerArgs) -> Result<Box<dyn Runner + 'a>> {
    bail!("--runner {:?}: this program has no drivers; use {}", args.runner, crate::harness::NAME)
}

/// Everything that an evaluation needs.
pub struct Job {
    /// The surface as the plan has it.
    pub spec: SurfaceSpec,
    /// Its heights.
    pub surface: Surface,
    /// The variant with the optics of the surface. For `exact`, a variant that only carries these optics.
    pub variant: Variant,
}

impl Job {
    /// Reads plan and surface, and checks that the pitch resolves the shortest wavelength, and that there is memory enough.
    pub fn new(
        surface: &SurfaceArgs,
        runner: &RunnerArgs,
        budget: &MemoryArgs,
        console: &Console,
    ) -> Result<Job> {
        let plan: Plan = surface.plan.read(console)?;
        let spec = plan.surface(&surface.surface)?.clone();
        let plan = plan.on(&spec);
        let (variant, min_nm) = match runner.runner {
            // the reference always integrates the whole visible range
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
        let needed = match runner.runner {
            Kind::Exact => {
                Reference::working_bytes(&surface.field, &variant.optics, Span::ANYWHERE)
            }
            Kind::Twin => memory::of(&surface.field, &variant)?.to_evaluate(),
            _ => memory::of(&surface.field, &variant)?.to_check_and_draw(),
        };
        let name = if runner.runner == Kind::Exact { "exact" } else { &variant.name };
        budget.check(&spec.name, name, surface.field.byte_count(), needed)?;
        Ok(Job { spec, surface, variant })
    }

    /// The variant on its surface, for runners.
    pub fn placement(&self) -> Placement<'_> {
        Placement {
            height: &self.surface.field,
            rotate_deg: self.spec.rotate_deg,
            variant: &self.variant,
        }
    }

    /// The runner that the options name.
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
