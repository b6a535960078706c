//! `cargo xtask tune`: finds the cheapest variant within an error budget.

mod text;
mod timing;
mod work;

use std::path::PathBuf;

use anyhow::Result;
use diffraction_cli::Outcome;
use diffraction_cli::args::{Light, SurfaceArgs};
use diffraction_cli::console::Console;
use diffraction_cli::memory::MemoryArgs;

use crate::commands::bench::Interface;
use crate::commands::restart;

const EXAMPLE: &str = "Examples:
  cargo xtask tune --plan plan.toml --surface blazed --budget-de 1.0
  cargo xtask tune --surface fingers --budget-de 0.5 --fits webgl2 --max-table-mib 4 --out target/tune
  cargo xtask tune --surface rows --budget-de 1 --light 40,0 --light 40,90 --backend gl --json

Candidates are the plan's own variants and a grid of presets over all that this version can build. All use the plan's [optics],
which defines the right colours. A candidate is within the budget if the 95th percentile of CIEDE2000 against the exact colours
is, under every light, over all compared directions and over the map alone. Times are measured under the first light.
The winner is printed as a [[preset]] to paste into a plan.

Exit code 1: no candidate is within the budget.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    surface: SurfaceArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    /// The error budget: maximum 95th percentile of CIEDE2000. 1 is about the smallest visible difference.
    #[arg(long, value_name = "DE", value_parser = positive, allow_hyphen_values = true)]
    budget_de: f64,
    /// Take only candidates whose tables fit the limits that every implementation of this profile guarantees.
    #[arg(long, value_enum)]
    fits: Option<Fits>,
    /// Take only candidates whose tables have at most M MiB.
    #[arg(long, value_name = "M", value_parser = positive, allow_hyphen_values = true)]
    max_table_mib: Option<f64>,
    /// Graphics interface for the times. Default: vulkan, or gl if there is no Vulkan adapter.
    #[arg(long, value_enum)]
    backend: Option<Interface>,
    /// Use the first adapter whose name or driver contains this text. Default: graphics cards before software drivers.
    #[arg(long, value_name = "SUBSTRING")]
    adapter: Option<String>,
    /// Width and height of the map for the times, in pixels. Errors are always computed on maps of 64 × 64 pixels and 2048 random
    /// directions.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=8192))]
    size: u32,
    /// Direction towards a light, in degrees: THETA from the normal, PHI about it from the tangent. May be repeated. Default: four
    /// lights, 20,0 0,0 60,0 75,0.
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true)]
    light: Vec<Light>,
    /// Time to measure each candidate, in seconds. At least 6 rounds are drawn in any case.
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = crate::commands::bench::seconds)]
    seconds: f64,
    /// Folder for results, for a report: records.jsonl and a picture of error against time.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// List every candidate that lost, not only a few for each reason.
    #[arg(long)]
    all: bool,
    /// Print one JSON object per candidate instead of tables.
    #[arg(long)]
    json: bool,
    /// Do not compare some of the driver's colours with the twin before the first result.
    #[arg(long)]
    unchecked: bool,
}

/// A profile with guaranteed limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Fits {
    Webgl2,
    Webgpu,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    restart::with_drivers()?;
    work::run(args, console)
}

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| *value > 0.0 && value.is_finite());
    value.ok_or_else(|| "expected a positive number".to_owned())
}

#[cfg(test)]
mod tests {
    use super::positive;

    #[test]
    fn a_budget_is_a_positive_number() {
        assert_eq!(positive("0.5"), Ok(0.5));
        assert!(["0", "-1", "nan", "inf", "x", ""].iter().all(|text| positive(text).is_err()));
    }
}
