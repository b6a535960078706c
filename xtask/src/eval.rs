//! `cargo xtask eval`: colours for given directions.

use std::path::PathBuf;

use crate::args::{RunnerArgs, SurfaceArgs, wavelength_nm};

const EXAMPLE: &str = "Example:
  cargo xtask eval --plan plan.toml --surface blazed --runner twin --directions directions.csv";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) surface: SurfaceArgs,
    #[command(flatten)]
    pub(crate) runner: RunnerArgs,
    /// One wavelength in nm: print rho and p2 instead of X, Y, Z.
    #[arg(long, value_name = "L", value_parser = wavelength_nm)]
    pub(crate) wavelength_nm: Option<f64>,
    /// Directions in degrees, header `theta_i,phi_i,theta_r,phi_r`.
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) directions: PathBuf,
}
