//! `cargo xtask compare`: every variant by every route against the exact reference, its twin and the other routes.

mod drivers;
mod sink;
mod summary;

use std::path::PathBuf;

use anyhow::Result;
use diffraction_cli::Outcome;
use diffraction_cli::args::{Exposure, Light, PlanArgs};
use diffraction_cli::console::Console;

use crate::commands::restart;

const EXAMPLE: &str = "Examples:
  cargo xtask compare --plan plan.toml --size 128
  cargo xtask compare --plan plans/texts.toml --light 0,0 --light 20,0 --out target/texts --resume
  cargo xtask compare --route twin --route vulkan:llvmpipe --variant texts --variant 'full-*' --json

Routes: twin (always there), vulkan, gl, spirv, hlsl (each on every adapter, or KIND:SUBSTRING), glsl450, glsl-es300,
webgpu, webgl2. Routes of a software driver inside a browser, and SwiftShader, take the variants of --subset.
Exit code 1: something lies outside its tolerance, a negative control was not caught, or a route failed.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    plan: PlanArgs,
    /// Only surfaces of these names.
    #[arg(long, value_name = "NAME")]
    surface: Vec<String>,
    /// Only variants that match; `texts` comes where it is named.
    #[arg(long, value_name = "GLOB")]
    variant: Vec<String>,
    /// Only these routes, KIND or KIND:ADAPTER, several by commas.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    route: Vec<String>,
    /// Side of the maps in pixels; 4096 drawn directions come on top.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(4..=4096))]
    size: u32,
    /// Direction of the light in degrees; several by repeating.
    #[arg(long, value_name = "THETA,PHI", default_value = "20,0", allow_hyphen_values = true)]
    light: Vec<Light>,
    /// Factor before colour differences: auto or a positive number.
    #[arg(long, value_name = "auto|V", default_value = "auto")]
    exposure: Exposure,
    /// Variants per surface that slow routes take, of every mode the cheapest first.
    #[arg(long, value_name = "N", default_value_t = 4)]
    subset: usize,
    /// Folder of records.jsonl and pictures.
    #[arg(long, value_name = "DIR", default_value = "target/compare")]
    out: PathBuf,
    /// Go on where an interrupted run stopped.
    #[arg(long)]
    resume: bool,
    /// Print the records, one JSON object per line.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    restart::with_drivers()?;
    drivers::run(args, console)
}
