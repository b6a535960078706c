//! From options to a runner on a driver.

use anyhow::Result;
use diffraction_cli::args::{Runner as Kind, RunnerArgs};
use diffraction_shaders::runner::{Placement, Runner};
use diffraction_shaders::variant::Pattern;

use clap::ValueEnum;

use crate::drivers::browser::{Api, Web};
use crate::drivers::egl::{Dialect, Egl};
use crate::drivers::gpu::{Backend, Gpu};
use crate::drivers::passthrough::{Language, Passthrough};
use crate::drivers::{Driver, DriverRunner, Prepared};
use crate::process::watched::{Place, child::enter};

/// Opens a runner on the driver that the options name.
pub(super) fn open<'a>(
    placement: Placement<'a>,
    args: &RunnerArgs,
) -> Result<Box<dyn Runner + 'a>> {
    let adapter = args.adapter.as_deref();
    if let Some(route) = args.runner.to_possible_value() {
        enter(Place {
            route: route.get_name().to_owned(),
            variant: Some(placement.variant.name.clone()),
            ..Place::default()
        });
    }
    let egl = |dialect| -> Result<Box<dyn Runner + 'a>> {
        let driver = Egl::open(dialect, adapter)?;
        runner(placement, driver, args)
    };
    let passthrough = |language| -> Result<Box<dyn Runner + 'a>> {
        let driver = Passthrough::open(language, adapter)?;
        runner(placement, driver, args)
    };
    let web = |api| -> Result<Box<dyn Runner + 'a>> {
        let driver = Web::open(api, adapter)?;
        runner(placement, driver, args)
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
            runner(placement, Gpu::open(backend, adapter)?, args)
        }
    }
}

/// A runner on a driver, which is checked unless the options say otherwise.
fn runner<'a, D: Driver + 'a>(
    placement: Placement<'a>,
    driver: D,
    args: &RunnerArgs,
) -> Result<Box<dyn Runner + 'a>> {
    let mut prepared = Prepared::new(placement)?;
    prepared.pattern = args.pattern.unwrap_or(Pattern::NONE);
    let runner = DriverRunner::with(prepared, driver);
    Ok(Box::new(if args.unchecked { runner } else { runner.checked()? }))
}
