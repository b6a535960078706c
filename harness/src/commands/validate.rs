//! `cargo xtask validate`: checks every emitted shader with external validators.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

use crate::validate::{Report, tools, validate};
use anyhow::{Result, bail};

use diffraction_cli::Outcome;
use diffraction_cli::console::Console;

const EXAMPLE: &str = "Examples:
  cargo xtask validate
  cargo xtask validate generated --require naga,spirv-val

hlsl-spirv-val compiles HLSL with glslangValidator and checks the result with spirv-val. reflection compares manifests with what
spirv-cross finds in SPIR-V. Tools that are not installed are skipped and listed.

Exit code 1: a tool rejected a file. Exit code 2: a required tool is missing.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// The package to validate, as generate wrote it.
    #[arg(value_name = "DIR", default_value = "generated")]
    folder: PathBuf,
    /// Tools that must be installed, separated by commas: naga, spirv-val, glslangValidator, hlsl-spirv-val, spirv-cross, reflection,
    /// tint.
    #[arg(long, value_name = "TOOL,…", value_delimiter = ',')]
    require: Vec<String>,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let report = validate(&args.folder, &tools(), &args.require)?;
    console.data(&table(&report))?;
    if report.tools.iter().all(|tool| tool.files == 0) {
        bail!("{}: has no shaders; run the command generate first", args.folder.display());
    }
    console.diagnostics(&report.diagnostics());
    Ok(if report.accepted() { Outcome::Done } else { Outcome::Findings })
}

fn table(report: &Report) -> String {
    let mut text = format!("{:<18} {:>6} {:>9}  version\n", "tool", "files", "rejected");
    for tool in &report.tools {
        let version = tool.version.as_deref().unwrap_or("not installed");
        let _ =
            writeln!(text, "{:<18} {:>6} {:>9}  {version}", tool.name, tool.files, tool.rejected);
    }
    // hundreds of files may share a reason, so each reason is printed once
    let mut reasons: BTreeMap<&str, Vec<_>> = BTreeMap::new();
    for unread in &report.unread {
        reasons.entry(&unread.reason).or_default().push(unread.file.display());
    }
    for (reason, files) in reasons {
        let more =
            if files.len() > 1 { format!(" and {} more", files.len() - 1) } else { String::new() };
        let _ = writeln!(text, "not checked: {}{more}: {reason}", files[0]);
    }
    text
}
