//! `cargo xtask explain`: generated text beside the template lines that it came from.

use std::num::NonZeroUsize;

use crate::args::PlanArgs;

const EXAMPLE: &str = "Example:
  cargo xtask explain full-taylor-t31 --line 40";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) plan: PlanArgs,
    /// The variant.
    #[arg(value_name = "VARIANT")]
    pub(crate) variant: String,
    /// Only this line of the generated text.
    #[arg(long, value_name = "N")]
    pub(crate) line: Option<NonZeroUsize>,
}
