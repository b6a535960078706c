//! `cargo xtask scene`: draws a variant as the skin of a 3-D body: pictures, sweeps and a turntable.

mod args;
mod flicker;
mod lights;
mod skin;
mod work;

use anyhow::Result;
use diffraction_cli::Outcome;
use diffraction_cli::console::Console;

use crate::commands::restart;

pub(crate) use args::Args;

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    args.check()?;
    restart::with_drivers()?;
    work::run(args, console)
}
