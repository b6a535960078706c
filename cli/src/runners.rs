//! From options to a runner, which evaluates a variant on a surface.

use anyhow::{Result, bail};
use diffraction_shaders::field::orders::OrderSum;
use diffraction_shaders::field::reference::{Reference, Span};
use diffraction_shaders::input;
use diffraction_shaders::light::{Cap, Light, Lights};
use diffraction_shaders::optics::{Matter, REFERENCE_NM, diffuser_scale};
use diffraction_shaders::plan::{Plan, SurfaceSource, SurfaceSpec, Variant};
use diffraction_shaders::runner::{
    Exact, Placement, Progress, Runner, TwinRunner, check_scaling, radiance_with, variant_scale,
};
use diffraction_shaders::surface::{self, Surface};
use diffraction_shaders::variant::Pattern;
use glam::DVec3;

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
        Job::with_optics(surface, runner, None, budget, console)
    }

    /// `named`: the variant whose optics the reference takes, instead of those of the plan.
    fn with_optics(
        surface: &SurfaceArgs,
        runner: &RunnerArgs,
        named: Option<&str>,
        budget: &MemoryArgs,
        console: &Console,
    ) -> Result<Job> {
        let plan: Plan = surface.plan.read(console)?;
        let mut spec = plan.surface(&surface.surface)?.clone();
        let plan = plan.on(&spec);
        let (variant, min_nm) = match runner.runner {
            // the reference always integrates the whole visible range
            Kind::Exact => {
                let named = named.map(|name| plan.variant(Some(name))).transpose()?;
                (Variant::texts(&named.map_or(plan.optics, |variant| variant.optics)), 380.0)
            }
            _ => {
                let variant = plan.variant(runner.variant.as_deref())?;
                let min_nm = variant.wavelengths.min_nm;
                (variant, min_nm)
            }
        };
        let mut surface = input::load_surface(&spec)?;
        surface.notes.iter().for_each(|note| console.note(note));
        match (&runner.pattern, runner.runner) {
            (Some(pattern), Kind::Exact) => {
                surface.field = pattern.scaled(&surface.field)?;
                spec.rotate_deg += pattern.angle_deg;
            }
            (Some(pattern), _) => pattern.check(&variant)?,
            (None, _) => {}
        }
        surface.field.check_pitch(&surface::subject(&spec), min_nm)?;
        let needed = match runner.runner {
            Kind::Exact => {
                let matter = Matter::new(&variant.optics)?;
                Reference::working_bytes(&surface.field, &variant.optics, &matter, Span::ANYWHERE)
            }
            Kind::Twin => memory::of(&surface.field, &variant)?.to_evaluate(),
            _ => memory::of(&surface.field, &variant)?.to_check_and_draw(),
        };
        let name = if runner.runner == Kind::Exact { "exact" } else { &variant.name };
        budget.check(&spec.name, name, surface.field.byte_count(), needed)?;
        Ok(Job { spec, surface, variant })
    }

    /// Like [`Job::new`], for a surface under lights. The reference takes the optics of the named variant, if one is
    /// named. It is an error if the lights have no meaning under these optics.
    pub fn under(
        lights: &Lights,
        surface: &SurfaceArgs,
        args: &RunnerArgs,
        budget: &MemoryArgs,
        console: &Console,
    ) -> Result<Job> {
        let job = Job::with_optics(surface, args, args.variant.as_deref(), budget, console)?;
        check_scaling(&job.variant.optics, lights)?;
        let field = &job.surface.field;
        if args.runner == Kind::Exact && lights.with_size().next().is_some() {
            let needed = OrderSum::working_bytes(field, &Matter::new(&job.variant.optics)?);
            budget.check(&job.spec.name, "exact", field.byte_count(), needed)?;
        }
        for note in job.narrow(lights) {
            console.note(&note);
        }
        Ok(job)
    }

    /// Notes about discs that are narrower than the orders of a patch that does not repeat are apart.
    fn narrow(&self, lights: &Lights) -> Vec<String> {
        let field = &self.surface.field;
        let apart_rad = REFERENCE_NM * 1e-3 / field.size_x_um().min(field.size_y_um());
        let synthetic = matches!(self.spec.source, SurfaceSource::Grating(_));
        let discs = lights.all.iter().filter_map(|light| match light.white().0 {
            Light::Disc { cap, .. } if !synthetic && 2.0 * cap.radius_rad < apart_rad => Some(cap),
            _ => None,
        });
        let note = |cap: &Cap| {
            format!(
                "a disc of {:.2}° is narrower than {:.2}°, the distance between the orders of a patch that is repeated without end; a larger scan, or a light of one direction, shows a surface that does not repeat",
                2.0 * cap.radius_rad.to_degrees(),
                apart_rad.to_degrees()
            )
        };
        discs.map(note).collect()
    }

    /// Radiance towards viewers under lights, X, Y, Z relative to a white of radiance 1.
    pub fn radiance(
        &self,
        runner: &dyn Runner,
        args: &RunnerArgs,
        lights: &Lights,
        views: &[DVec3],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        let scale = match args.runner {
            Kind::Exact => diffuser_scale(&self.variant.optics)?,
            _ => variant_scale(self.placement())?,
        };
        Ok(radiance_with(runner, scale, lights, views, progress)?)
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
            Kind::Twin => {
                let twin = TwinRunner::new(placement, !args.unpacked)?;
                let pattern = args.pattern.unwrap_or(Pattern::NONE);
                Box::new(twin.patterned(&pattern))
            }
            _ => drivers(placement, args)?,
        })
    }
}
