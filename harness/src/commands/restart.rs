//! Commands that need drivers start this program again, once, where its environment lacks what the drivers read: Mesa's 32-bit
//! float targets, and Vulkan drivers that its loader would not find. What the user has set stays.

use std::process::Command;

use anyhow::{Result, bail};
use diffraction_cli::args::RunnerArgs;
use diffraction_cli::replace;

use crate::drivers::icd;

/// What Mesa's drivers have to be told.
const MESA: [(&str, &str); 2] = [
    // its GL renders to 32-bit float targets only when asked to
    ("MESA_EXTENSION_OVERRIDE", "+GL_ARB_color_buffer_float"),
    // its Vulkan otherwise looks for a Wayland display, and complains on stderr where there is none
    ("NODEVICE_SELECT", "1"),
];

const MARK: &str = "DIFFRACTION_STARTED_AGAIN";

/// Returns when the environment has all that drivers read; else replaces this process by one that has.
pub(crate) fn with_drivers() -> Result<()> {
    with_drivers_and(&[])
}

/// The same where a runner is on a driver.
pub(crate) fn with_drivers_for(runner: &RunnerArgs) -> Result<()> {
    if runner.runner.is_driver() { with_drivers() } else { Ok(()) }
}

/// The same with more variables of the environment, where they are not set to something else.
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
            "started again for {}, and the environment still lacks it; set it by hand",
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
