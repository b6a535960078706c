//! `cargo xtask validate`: checks every emitted shader with external validators.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Duration;

use crate::validate::{Report, tools, validate};
use anyhow::{Result, bail};

use diffraction_cli::Outcome;
use diffraction_cli::console::Console;
use diffraction_shaders::disk::{Access, FolderLock};

const EXAMPLE: &str = "Examples:
  cargo xtask validate
  cargo xtask validate generated --require naga,spirv-val

hlsl-spirv-val compiles HLSL with glslangValidator and checks the result with spirv-val. dxc compiles it to DXIL, and to SPIR-V for
spirv-val. reflection compares manifests with what spirv-cross finds in SPIR-V. metal-cpu compiles Metal with g++ and a small
metal_stdlib of ours and runs the probes of each variant; it is not Apple's compiler. It executes the texts, so validate only packages
that you trust.

Tools that are not installed are skipped and listed. A tool counts only if it accepts a small package of ours, and rejects it once it
is spoilt.

Exit code 1: a tool rejected a file, or did not answer. Exit code 2: a required tool is missing or not believed.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// The package to validate, as generate wrote it.
    #[arg(value_name = "DIR", default_value = "generated")]
    folder: PathBuf,
    /// Tools that must be installed, separated by commas: naga, spirv-val, glslangValidator, hlsl-spirv-val, dxc, spirv-cross,
    /// reflection, tint, metal-cpu.
    #[arg(long, value_name = "TOOL,…", value_delimiter = ',')]
    require: Vec<String>,
    /// Maximum time of a tool for one file, in seconds.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    time_limit: f64,
    /// Install DXC's library first (67 MB to download, from Python's package index), into the user's cache folder.
    #[arg(long)]
    setup: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds: &f64| (0.1..=3600.0).contains(seconds));
    seconds.ok_or_else(|| "needs a number of seconds, 0.1 to 3600".to_owned())
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    if args.setup {
        super::setup::DXC.install(console)?;
    }
    let tools = tools(Duration::from_secs_f64(args.time_limit));
    let waiting = |text: &str| console.note(text);
    let _lock = FolderLock::take(&args.folder, Access::Read, &waiting)?;
    let report = validate(&args.folder, &tools, &args.require)?;
    console.data(&table(&report))?;
    if report.tools.iter().all(|tool| tool.files + tool.skipped == 0) {
        bail!("{}: has no shaders; run the command generate first", args.folder.display());
    }
    console.diagnostics(&report.diagnostics());
    Ok(if report.accepted() { Outcome::Done } else { Outcome::Findings })
}

fn table(report: &Report) -> String {
    let mut text = format!("{:<18} {:>6} {:>9}  version\n", "tool", "files", "rejected");
    for tool in &report.tools {
        let mut notes = Vec::new();
        notes.extend(tool.version.clone());
        if let Some((count, worst)) = tool.executed {
            notes.push(format!("{count} files executed, worst probe {worst:.3} tolerances"));
        }
        notes.extend(tool.trouble.as_ref().map(ToString::to_string));
        let notes = notes.join("; ");
        let _ = writeln!(text, "{:<18} {:>6} {:>9}  {notes}", tool.name, tool.files, tool.rejected);
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
