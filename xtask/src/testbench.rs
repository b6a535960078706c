//! `cargo xtask testbench`: the response over wavelength and angle, and the period that it tells.

use std::path::PathBuf;

use crate::args::SurfaceArgs;

const EXAMPLE: &str = "Example:
  cargo xtask testbench --plan plan.toml --surface blazed --theta-i 75 --csv response.csv";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) surface: SurfaceArgs,
    /// The variant; not needed where the plan has only one.
    #[arg(long, value_name = "NAME")]
    pub(crate) variant: Option<String>,
    /// Angle of incidence in degrees.
    #[arg(long, value_name = "DEG", default_value_t = 75.0)]
    pub(crate) theta_i: f64,
    /// Expected period in nm; the dominant one of the surface by default.
    #[arg(long, value_name = "D")]
    pub(crate) period_nm: Option<f64>,
    /// Write the response as CSV.
    #[arg(long, value_name = "F")]
    pub(crate) csv: Option<PathBuf>,
    /// Draw the response as SVG.
    #[arg(long, value_name = "F")]
    pub(crate) svg: Option<PathBuf>,
    /// Print the result as one line of JSON.
    #[arg(long)]
    pub(crate) json: bool,
}
