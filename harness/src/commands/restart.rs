//! Restarts the program with environment variables that drivers need: Mesa's 32-bit float targets, and Vulkan drivers that the
//! loader would not find. Commands on drivers do this once, if variables are missing. Variables that the user has set are kept.

use std::process::Command;

use anyhow::{Result, bail};
use diffraction_cli::args::RunnerArgs;
use diffraction_cli::replace;

use crate::drivers::icd;

/// Variables for Mesa's drivers.
const MESA: [(&str, &str); 2] = [
    // Mesa's GL renders to 32-bit float targets only with this
    ("MESA_EXTENSION_OVERRIDE", "+GL_ARB_color_buffer_float"),
    // otherwise Mesa's Vulkan looks for a Wayland display and prints a warning if there is no display
    ("NODEVICE_SELECT", "1"),
];

const MARK: &str = "DIFFRACTION_STARTED_AGAIN";

/// Returns if the environment has all variables that drivers need. Otherwise replaces this process by one that has them.
pub(crate) fn with_drivers() -> Result<()> {
    with_drivers_and(&[])
}

/// Like [`with_drivers`], if the runner is on a driver.
pub(crate) fn with_drivers_for(runner: &RunnerArgs) -> Result<()> {
    if runner.runner.is_driver() { with_drivers() } else { Ok(()) }
}

/// Like [`with_drivers`], with further variables, unless the user has set them.
pub(crate) fn with_drivers_and(more: &[(&str, &str)]) -> Result<()> {
    let lacking = |(key, _): &&(&str, &str)| std::env::var_os(key).is_none();
    let missing: Vec<&(&str, &str)> = MESA.iter().chain(more).filter(lacking).collect();
    let drivers = icd::addition();
    if missing.is_empty() && drivers.is_none() {
        return Ok(());
    }
    if std::env::var_os(MARK).is_some() {
        let mut names: Vec<&str> = missing.iter().map(|(key, _)| *key).collect();
        names.extend(drivers.is_some().then_some(icd::ADD_DRIVERS));
        bail!(
            "{}: not set, even after a restart of this program; set it by hand",
            names.join(", ")
        );
    }
    let mut command = Command::new(std::env::current_exe()?);
    command.args(std::env::args_os().skip(1)).env(MARK, "1");
    command.envs(missing.into_iter().copied());
    if let Some(drivers) = drivers {
        command.env(icd::ADD_DRIVERS, drivers);
    }
    Err(replace::by(command))
}
