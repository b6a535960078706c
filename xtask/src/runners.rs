//! From flags to something that evaluates a variant on a surface.

use anyhow::{Result, bail};
use diffraction_shaders::height::{self, Surface};
use diffraction_shaders::input;
use diffraction_shaders::plan::{Plan, SurfaceSpec, Variant};
use diffraction_shaders::runner::{Exact, Runner, Subject, TwinRunner};

use crate::args::{Runner as Kind, RunnerArgs, SurfaceArgs};
use crate::console::Console;
use crate::reexec;

/// Everything that an evaluation needs to know.
pub(crate) struct Job {
    /// The surface as planned.
    pub(crate) spec: SurfaceSpec,
    /// Its heights.
    pub(crate) surface: Surface,
    /// The variant; for `exact` one that only carries the plan's optics.
    pub(crate) variant: Variant,
}

impl Job {
    /// Reads plan and surface; checks that the pitch resolves the shortest wavelength that will be asked for.
    pub(crate) fn new(
        surface: &SurfaceArgs,
        runner: &RunnerArgs,
        console: &Console,
    ) -> Result<Job> {
        if runner.runner.is_driver() {
            reexec::with_gpu(std::env::args_os().skip(1).collect())?;
        }
        let plan: Plan = surface.plan.read(console)?;
        let spec = plan.surface(&surface.surface)?.clone();
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
        surface.field.check_pitch(&height::subject(&spec), min_nm)?;
        Ok(Job { spec, surface, variant })
    }

    /// The subject that runners evaluate.
    pub(crate) fn subject(&self) -> Subject<'_> {
        Subject {
            height: &self.surface.field,
            rotate_deg: self.spec.rotate_deg,
            variant: &self.variant,
        }
    }

    /// The runner that the flags name.
    pub(crate) fn runner(&self, args: &RunnerArgs) -> Result<Box<dyn Runner + '_>> {
        let subject = self.subject();
        if args.unpacked && args.runner != Kind::Twin {
            bail!(
                "--unpacked: only the twin can read tables before they are rounded; use --runner twin"
            );
        }
        Ok(match args.runner {
            Kind::Exact => Box::new(Exact(subject)),
            Kind::Twin => Box::new(TwinRunner::new(subject, !args.unpacked)?),
            _ => shader(subject, args)?,
        })
    }
}

#[cfg(feature = "gpu")]
fn shader<'a>(subject: Subject<'a>, args: &RunnerArgs) -> Result<Box<dyn Runner + 'a>> {
    use diffraction_shaders::runner::browser::{Api, Web};
    use diffraction_shaders::runner::egl::{Dialect, Egl};
    use diffraction_shaders::runner::gpu::{Backend, Gpu};
    use diffraction_shaders::runner::passthrough::{Language, Passthrough};
    use diffraction_shaders::runner::{DriverRunner, Prepared, ShaderRunner};
    let adapter = args.adapter.as_deref();
    let egl = |dialect| -> Result<Box<dyn Runner + 'a>> {
        let driver = Egl::open(dialect, adapter)?;
        Ok(Box::new(DriverRunner::with(Prepared::new(subject)?, driver)))
    };
    let passthrough = |language| -> Result<Box<dyn Runner + 'a>> {
        let driver = Passthrough::open(language, adapter)?;
        Ok(Box::new(DriverRunner::with(Prepared::new(subject)?, driver)))
    };
    let web = |api| -> Result<Box<dyn Runner + 'a>> {
        let driver = Web::open(api, adapter)?;
        Ok(Box::new(DriverRunner::with(Prepared::new(subject)?, driver)))
    };
    match args.runner {
        Kind::Spirv => passthrough(Language::Spirv),
        Kind::Hlsl => passthrough(Language::Hlsl),
        Kind::WebGpu => web(Api::WebGpu),
        Kind::WebGl2 => web(Api::WebGl2),
        Kind::Glsl450 => egl(Dialect::Glsl450),
        Kind::GlslEs300 => egl(Dialect::GlslEs300),
        kind => {
            let backend = if kind == Kind::Gl { Backend::Gl } else { Backend::Vulkan };
            Ok(Box::new(ShaderRunner::new(subject, Gpu::open(backend, adapter)?)?))
        }
    }
}

#[cfg(not(feature = "gpu"))]
fn shader<'a>(_: Subject<'a>, _: &RunnerArgs) -> Result<Box<dyn Runner + 'a>> {
    bail!("this xtask was built without its drivers: {}", reexec::REMEDY)
}
