//! `cargo xtask render`: a BRDF map.

use std::path::PathBuf;

use crate::args::{Exposure, Light, RunnerArgs, SurfaceArgs};

const EXAMPLE: &str = "Example:
  cargo xtask render --plan plan.toml --surface blazed --light 20,0 --size 512 --out blazed.png";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) surface: SurfaceArgs,
    #[command(flatten)]
    pub(crate) runner: RunnerArgs,
    /// Direction of the light in degrees.
    #[arg(long, value_name = "THETA,PHI", default_value = "20,0")]
    pub(crate) light: Light,
    /// Side of the map in pixels.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=8192))]
    pub(crate) size: u32,
    /// Factor before the sRGB curve: auto or a positive number.
    #[arg(long, value_name = "auto|V", default_value = "auto")]
    pub(crate) exposure: Exposure,
    /// The picture: .png (sRGB, clamped) or .exr (linear radiance factor).
    #[arg(long, value_name = "FILE.png|.exr")]
    pub(crate) out: PathBuf,
}
