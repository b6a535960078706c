//! `cargo xtask scene`: a variant on the skin of a body, as stills, sweeps and a turntable.

mod args;
#[cfg(feature = "gpu")]
mod work;

use anyhow::Result;

use crate::Outcome;
use crate::console::Console;
use crate::reexec;

pub(crate) use args::Args;

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    args.check()?;
    reexec::with_gpu(std::env::args_os().skip(1).collect())?;
    draw(args, console)
}

#[cfg(feature = "gpu")]
fn draw(args: &Args, console: &Console) -> Result<Outcome> {
    work::run(args, console)
}

#[cfg(not(feature = "gpu"))]
fn draw(_: &Args, _: &Console) -> Result<Outcome> {
    anyhow::bail!("this xtask was built without its drivers: {}", reexec::REMEDY)
}
