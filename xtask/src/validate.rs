//! `cargo xtask validate`: external validators over every emitted file.

use std::path::PathBuf;

const EXAMPLE: &str = "Example:
  cargo xtask validate generated --require naga,spirv-val";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// The package to validate.
    #[arg(value_name = "DIR", default_value = "generated")]
    pub(crate) folder: PathBuf,
    /// Tools that must be installed: naga, spirv-val, glslangValidator, spirv-cross, tint.
    #[arg(long, value_name = "TOOL,…", value_delimiter = ',')]
    pub(crate) require: Vec<String>,
}
