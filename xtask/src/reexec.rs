//! Commands that need the feature `gpu` start themselves again with it, Mesa with 32-bit float targets, and Vulkan with drivers
//! that its loader would not find. What the user has set stays.

use std::ffi::OsString;
use std::process::Command;

use anyhow::{Result, bail};
use diffraction_shaders::runner::icd;

const MESA_KEY: &str = "MESA_EXTENSION_OVERRIDE";
const MESA_VALUE: &str = "+GL_ARB_color_buffer_float";
/// What brings the drivers.
#[cfg(not(feature = "gpu"))]
pub(crate) const REMEDY: &str = "run cargo build --release -p xtask --features gpu";

const MARK: &str = "XTASK_STARTED_AGAIN";

/// Returns when this process has the feature `gpu`, Mesa's extension is set and no driver is left to add; else replaces it by
/// one that has.
/// `args` are those of the command line after the name of the program.
pub(crate) fn with_gpu(args: Vec<OsString>) -> Result<()> {
    with_gpu_and(args, &[])
}

/// The same with more variables of the environment, where they are not set to something else.
pub(crate) fn with_gpu_and(args: Vec<OsString>, more: &[(&str, &str)]) -> Result<()> {
    let lacks_feature = !cfg!(feature = "gpu");
    let drivers = icd::addition();
    let is_set = |key: &str| std::env::var_os(key).is_some();
    let all_set = is_set(MESA_KEY) && more.iter().all(|(key, _)| is_set(key));
    if !lacks_feature && all_set && drivers.is_none() {
        return Ok(());
    }
    if std::env::var_os(MARK).is_some() {
        bail!("xtask started itself again and still lacks the feature gpu, {MESA_KEY} or drivers");
    }
    let mut command = if lacks_feature {
        eprintln!("note: building the GPU runner: cargo run --release -p xtask --features gpu");
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        // from any folder: the paths of the command line stay relative to the present one
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
        cargo.args(["run", "--release", "-p", "xtask", "--features", "gpu"]);
        cargo.args([
            "--manifest-path",
            &format!("{root}/Cargo.toml"),
            "--target-dir",
            &format!("{root}/target/gpu"),
            "--",
        ]);
        cargo
    } else {
        Command::new(std::env::current_exe()?)
    };
    for (key, value) in [(MESA_KEY, MESA_VALUE)].iter().chain(more).filter(|(key, _)| !is_set(key))
    {
        command.env(key, value);
    }
    if let Some(drivers) = drivers {
        command.env(icd::ADD_DRIVERS, drivers);
    }
    // else Mesa's Vulkan looks for a Wayland display and complains
    command.env(MARK, "1").env("NODEVICE_SELECT", "1").args(args);
    replace(command)
}

#[cfg(unix)]
fn replace(mut command: Command) -> Result<()> {
    use std::os::unix::process::CommandExt;
    let error = command.exec();
    bail!("{} cannot be started: {error}", command.get_program().display())
}

#[cfg(not(unix))]
fn replace(mut command: Command) -> Result<()> {
    let status = command.status()?;
    std::process::exit(status.code().unwrap_or(2))
}
