//! `cargo xtask inspect`: what a user asks first about a surface.

use crate::args::SurfaceArgs;

const EXAMPLE: &str = "Example:
  cargo xtask inspect --plan plan.toml --surface blazed";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) surface: SurfaceArgs,
}
