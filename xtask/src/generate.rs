//! `cargo xtask generate`: from a plan to a folder, or the comparison of the two.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use diffraction_shaders::package::{self, Package, Report};
use diffraction_shaders::plan::{Plan, Target, Variant};

use crate::Outcome;
use crate::args::PlanArgs;
use crate::console::Console;
use crate::interrupt;

const EXAMPLE: &str = "Examples:
  cargo xtask generate
  cargo xtask generate --check
  cargo xtask generate --plan plan.toml --out generated --variant 'full-*' --target wgsl,spirv";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    plan: PlanArgs,
    /// The folder to write: absent, empty, or one written before.
    #[arg(long, value_name = "DIR", default_value = "generated")]
    out: PathBuf,
    /// Write nothing; list changed, missing, orphan and foreign files.
    #[arg(long)]
    check: bool,
    /// Rebuild only the variants that match (`*`, `?`), keep the rest; may be repeated.
    #[arg(long, value_name = "GLOB")]
    variant: Vec<String>,
    /// Rebuild only these targets, keep the rest.
    #[arg(long, value_name = "T,…", value_delimiter = ',')]
    target: Vec<String>,
    /// Threads to use; all cores by default.
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    /// Neither read nor write the cache of tables.
    #[arg(long)]
    no_cache: bool,
}

/// What a run builds.
#[derive(Clone, Debug)]
pub(crate) struct Selection {
    /// In the order of the plan.
    pub(crate) variants: Vec<Variant>,
    /// In the order of the plan or of the command line.
    pub(crate) targets: Vec<Target>,
    /// Whether that is the whole plan; else the package is laid over what the folder holds.
    pub(crate) is_whole: bool,
    /// Whether tables may come from, and go to, the cache.
    pub(crate) cache: bool,
}

/// `build` makes the sealed package of a selection; of a partial one, laid over the folder (`Package::overlay`).
pub(crate) fn run(
    args: &Args,
    console: &Console,
    build: impl FnOnce(&Plan, &Selection, &Path) -> Result<Package> + Send,
) -> Result<Outcome> {
    interrupt::full_disk_is_an_error()?;
    let cancel = interrupt::install(&args.out)?;
    let plan = args.plan.read(console)?;
    let selection = select(args, &plan)?;
    let threads = args.jobs.map_or(0, NonZeroUsize::get);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("threads cannot be started")?;
    let package = pool.install(|| build(&plan, &selection, &args.out))?;
    if args.check {
        let report = package::check(&package, &args.out)?;
        console.data(&told(&report, args))?;
        return Ok(if report.is_stale() { Outcome::Findings } else { Outcome::Done });
    }
    let written = match package::write_unless(&package, &args.out, &cancel) {
        Err(_) if cancel.is_cancelled() => interrupt::exit(),
        other => other?,
    };
    if let Some(folder) = &written.left_behind {
        console.note(&format!("{} could not be removed entirely; the next run tries again", folder.display()));
    }
    let mib = written.bytes as f64 / f64::from(1 << 20);
    console.note(&format!("{}: {} files, {mib:.1} MiB", args.out.display(), written.files));
    Ok(Outcome::Done)
}

fn select(args: &Args, plan: &Plan) -> Result<Selection> {
    let targets: Vec<Target> = args.target.iter().map(|word| Target::parse(word)).collect::<Result<_, _>>()?;
    Ok(Selection {
        variants: plan.select(&args.variant)?,
        is_whole: args.variant.is_empty() && targets.is_empty(),
        targets: if targets.is_empty() { plan.targets.clone() } else { targets },
        cache: !args.no_cache,
    })
}

fn told(report: &Report, args: &Args) -> String {
    let groups = [
        ("changed", &report.changed),
        ("missing", &report.missing),
        ("orphan", &report.orphan),
        ("foreign", &report.foreign),
    ];
    let lines = groups.iter().flat_map(|(what, paths)| paths.iter().map(move |path| format!("{what} {path}\n")));
    let mut text: String = lines.collect();
    if report.is_stale() {
        let (plan, out) = (args.plan.plan.display(), args.out.display());
        text += &format!("to mend: cargo xtask generate --plan {plan} --out {out}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use clap::Parser;
    use diffraction_shaders::package::Compare;

    use super::*;
    use crate::console::MessageFormat;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    const PLAN: &str = "schema = 1\n[[surface]]\nname = \"a\"\ngrating = { kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 100 }\n";

    fn names(_: &Plan, selection: &Selection, _: &Path) -> Result<Package> {
        let mut package = Package::new();
        for variant in &selection.variants {
            package.insert(&format!("{}.txt", variant.name), variant.canonical(), Compare::Bytes)?;
        }
        package.seal(BTreeMap::new())?;
        Ok(package)
    }

    #[test]
    fn a_package_is_written_then_checks_clean_until_it_is_edited() {
        let base = tempfile::tempdir().unwrap();
        let (plan, out) = (base.path().join("plan.toml"), base.path().join("out"));
        fs::write(&plan, PLAN).unwrap();
        let console = Console::new(MessageFormat::Human);
        let line = |more: &[&str]| {
            let plain = ["generate", "--plan", plan.to_str().unwrap(), "--out", out.to_str().unwrap()];
            run(&Line::parse_from(plain.iter().chain(more)).args, &console, names)
        };
        assert_eq!(line(&["--check"]).unwrap(), Outcome::Findings);
        assert_eq!(line(&["--jobs", "1"]).unwrap(), Outcome::Done);
        assert_eq!(line(&["--check"]).unwrap(), Outcome::Done);
        fs::write(out.join("full-taylor-t31.txt"), "edited").unwrap();
        assert_eq!(line(&["--check"]).unwrap(), Outcome::Findings);
        fs::write(out.join("mine"), "mine").unwrap();
        assert_eq!(line(&["--variant", "*", "--target", "wgsl,spirv"]).unwrap(), Outcome::Done);
        assert!(out.join("mine").exists());
        assert!(line(&["--target", "hlsl"]).is_err());
        assert!(line(&["--variant", "none"]).is_err());
    }
}
