//! `cargo xtask tune`: the cheapest variant within an error budget.

mod text;
mod timing;
mod work;

use std::path::PathBuf;

use anyhow::Result;
use diffraction_cli::Outcome;
use diffraction_cli::args::{Light, SurfaceArgs};
use diffraction_cli::console::Console;

use crate::commands::bench::Interface;
use crate::commands::restart;

const EXAMPLE: &str = "Examples:
  cargo xtask tune --plan plan.toml --surface blazed --budget-de 1.0
  cargo xtask tune --surface fingers --budget-de 0.5 --fits webgl2 --max-table-mib 4 --out target/tune
  cargo xtask tune --surface rows --budget-de 1 --light 40,0 --light 40,90 --backend gl --json

The candidates are presets of a plan from a grid over what this version builds, and the plan's own variants; [optics] stays
as it is, since it says what is right. The budget holds for the 95th percentile of CIEDE2000 against the exact colours, of
all directions compared and of the map, under every light; times are those of the first light.
Exit code 1: nothing is within the budget.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    surface: SurfaceArgs,
    /// Greatest 95th percentile of CIEDE2000.
    #[arg(long, value_name = "DE", value_parser = positive, allow_hyphen_values = true)]
    budget_de: f64,
    /// Tables must be within what every implementation of this guarantees.
    #[arg(long, value_enum)]
    fits: Option<Fits>,
    /// Most MiB of tables.
    #[arg(long, value_name = "M", value_parser = positive, allow_hyphen_values = true)]
    max_table_mib: Option<f64>,
    /// Measure times by this interface; else by vulkan, or gl where there is none.
    #[arg(long, value_enum)]
    backend: Option<Interface>,
    /// Take the adapter whose name or driver contains this; else graphics cards come first.
    #[arg(long, value_name = "SUBSTRING")]
    adapter: Option<String>,
    /// Side in pixels of the map that is timed; errors are always those of maps of 64 × 64 and 2048 drawn directions.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=8192))]
    size: u32,
    /// Direction of a light in degrees; several by repeating. Without it 20,0 0,0 60,0 and 75,0.
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true)]
    light: Vec<Light>,
    /// Seconds for each time; the fewest rounds are always drawn.
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = crate::commands::bench::seconds)]
    seconds: f64,
    /// Write records.jsonl and a picture of the front to this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Name every candidate that lost, not just a few for each reason.
    #[arg(long)]
    all: bool,
    /// Print one JSON object per candidate instead of tables.
    #[arg(long)]
    json: bool,
}

/// A profile whose limits can be asked for.
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
