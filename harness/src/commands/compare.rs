//! `cargo xtask compare`: compares every variant, by every route, with the exact reference, its twin and the other routes.

mod drivers;
mod sink;
mod summary;

use std::path::PathBuf;

use anyhow::Result;
use diffraction_cli::Outcome;
use diffraction_cli::args::{Exposure, Light, PlanArgs};
use diffraction_cli::console::Console;
use diffraction_cli::memory::MemoryArgs;

use crate::commands::restart;

const EXAMPLE: &str = "Examples:
  cargo xtask compare --plan plan.toml --size 128
  cargo xtask compare --plan plans/texts.toml --light 0,0 --light 20,0 --out target/texts --resume
  cargo xtask compare --lights lights.toml --size 64
  cargo xtask compare --route twin --route vulkan:llvmpipe --variant texts --variant 'full-*' --json

A route is a way from a variant to its colours: twin (the variant's algorithm in 64 bits, always there), vulkan, gl, spirv,
hlsl (these four on every adapter, or with KIND:SUBSTRING on one), glsl450, glsl-es300, webgpu, webgl2. Slow routes
(SwiftShader, webgpu, webgl2) take only the variants of --subset. A negative control is a shader made wrong
on purpose, which the comparison must catch. A run that waits for another one on the same folder keeps the results of that one.

Exit code 1: something is outside its tolerance, a negative control was not caught, or a route failed.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    plan: PlanArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    /// Compare only the surface of this name; may be repeated. Default: all surfaces.
    #[arg(long, value_name = "NAME")]
    surface: Vec<String>,
    /// Compare only variants whose name matches this pattern (`*`, `?`); may be repeated. Default: all variants. The built-in
    /// `texts` must be named.
    #[arg(long, value_name = "GLOB")]
    variant: Vec<String>,
    /// Take only these routes, each KIND or KIND:SUBSTRING (part of the adapter's name), separated by commas. Default: all that
    /// this machine has.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    route: Vec<String>,
    /// Width and height of the maps, in pixels. 4096 random directions are compared in addition.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(4..=4096))]
    size: u32,
    /// Direction towards the light, in degrees: THETA from the normal, PHI about it from the tangent. May be repeated.
    #[arg(long, value_name = "THETA,PHI", default_value = "20,0", allow_hyphen_values = true)]
    light: Vec<Light>,
    /// TOML file of lights: single directions, discs, polygons, skies, maps. Compare the radiance of all variants that have functions for them,
    /// instead of colours under --light.
    #[arg(long, value_name = "FILE.toml", conflicts_with = "light")]
    lights: Option<PathBuf>,
    /// Factor on the colours before colour differences are computed: a positive number, or auto: from the exact map.
    #[arg(long, value_name = "auto|V", default_value = "auto")]
    exposure: Exposure,
    /// Number of variants per surface that slow routes take: of each mode the cheapest first.
    #[arg(long, value_name = "N", default_value_t = 4)]
    subset: usize,
    /// Folder for results: records.jsonl and pictures.
    #[arg(long, value_name = "DIR", default_value = "target/compare")]
    out: PathBuf,
    /// Continue an interrupted run: keep its results in --out and compute only the missing ones.
    #[arg(long)]
    resume: bool,
    /// Print one JSON object per result instead of tables.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    restart::with_routes(&[])?;
    drivers::run(args, console)
}
