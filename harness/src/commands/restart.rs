//! Restarts the program as a watched child, with environment variables that drivers need: Mesa's 32-bit float targets, and Vulkan
//! drivers that the loader would not find. Commands on drivers do this once. Variables that the user has set are kept.

use std::process::Command;

use anyhow::{Result, bail};
use diffraction_cli::args::RunnerArgs;
#[cfg(unix)]
use diffraction_shaders::error::Error;

use crate::drivers::icd;
#[cfg(unix)]
use crate::process::watched;

/// Variables for Mesa's drivers.
const MESA: [(&str, &str); 2] = [
    // Mesa's GL renders to 32-bit float targets only with this
    ("MESA_EXTENSION_OVERRIDE", "+GL_ARB_color_buffer_float"),
    // otherwise Mesa's Vulkan looks for a Wayland display and prints a warning if there is no display
    ("NODEVICE_SELECT", "1"),
];

const MARK: &str = "DIFFRACTION_STARTED_AGAIN";

/// Returns in the child. In the parent, watches the child and ends with its exit code; returns only an error.
pub(crate) fn with_drivers() -> Result<()> {
    restarted(&[], false)
}

/// Like [`with_drivers`], if the runner is on a driver.
pub(crate) fn with_drivers_for(runner: &RunnerArgs) -> Result<()> {
    if runner.runner.is_driver() { with_drivers() } else { Ok(()) }
}

/// Like [`with_drivers`], for a command that goes on with its other routes if a driver crashes. With further variables, unless the
/// user has set them.
pub(crate) fn with_routes(more: &[(&str, &str)]) -> Result<()> {
    restarted(more, true)
}

fn restarted(more: &[(&str, &str)], goes_on: bool) -> Result<()> {
    let lacking = |(key, _): &&(&str, &str)| std::env::var_os(key).is_none();
    let missing: Vec<&(&str, &str)> = MESA.iter().chain(more).filter(lacking).collect();
    let drivers = icd::addition();
    if std::env::var_os(MARK).is_some() {
        if missing.is_empty() && drivers.is_none() {
            return begin();
        }
        let mut names: Vec<&str> = missing.iter().map(|(key, _)| *key).collect();
        names.extend(drivers.is_some().then_some(icd::ADD_DRIVERS));
        bail!(
            "{}: not set, even after a restart of this program; set it by hand",
            names.join(", ")
        );
    }
    let command = || {
        let mut command = Command::new(std::env::current_exe()?);
        command.args(std::env::args_os().skip(1)).env(MARK, "1");
        command.envs(missing.iter().map(|(key, value)| (key, value)));
        if let Some(drivers) = &drivers {
            command.env(icd::ADD_DRIVERS, drivers);
        }
        Ok(command)
    };
    run(command, goes_on)
}

#[cfg(unix)]
fn begin() -> Result<()> {
    use anyhow::Context;
    watched::child::begin()
        .with_context(|| format!("{MARK} is set, but this process has no parent; unset it"))
}

#[cfg(not(unix))]
fn begin() -> Result<()> {
    Ok(())
}

#[cfg(unix)]
fn run(command: impl Fn() -> std::io::Result<Command>, goes_on: bool) -> Result<()> {
    match watched::watch(command, goes_on)? {
        Ok(code) => std::process::exit(code),
        Err(crash) if crash.place.route.is_empty() => {
            bail!("the program ended unexpectedly ({})", crash.how)
        }
        Err(crash) => {
            let cause =
                format!("the driver ended the program ({}) while {}", crash.how, crash.place);
            Err(Error::new(crash.place.route, cause)
                .remedy("the driver is at fault: update it, or choose another adapter or route")
                .into())
        }
    }
}

#[cfg(not(unix))]
fn run(command: impl Fn() -> std::io::Result<Command>, _: bool) -> Result<()> {
    Err(diffraction_cli::replace::by(command()?))
}
