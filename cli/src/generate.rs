//! `cargo xtask generate`: builds the package of a plan, or compares it with a folder.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result};
use diffraction_shaders::disk::{Access, FolderLock};
use diffraction_shaders::error::shell_path;
use diffraction_shaders::package::compile::{Compiler, Step};
use diffraction_shaders::package::{self, GENERATED_BY, Output, Package, Report, Stamp};
use diffraction_shaders::plan::{Plan, Target, Variant};

use crate::Outcome;
use crate::args::PlanArgs;
use crate::console::Console;
use crate::memory::MemoryArgs;
use crate::program::spoken;
use crate::unchanged::{self, Expected};
use crate::{interrupt, progress};

const EXAMPLE: &str = "Examples:
  cargo xtask generate
  cargo xtask generate --check
  cargo xtask generate --plan plan.toml --out generated --variant 'full-*' --target wgsl,spirv

Foreign files in the folder are kept. While another run writes to the folder, this one waits for it. What a killed run left, the
next one completes or removes. Exit code 1: --check found differences.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    plan: PlanArgs,
    /// Folder for the package: new, empty, or written by this command before.
    #[arg(long, value_name = "DIR", default_value = "generated")]
    out: PathBuf,
    /// Write nothing. Compare the folder with what would be written, and list changed, missing, orphan (no longer generated) and
    /// foreign (not ours) files.
    #[arg(long)]
    check: bool,
    /// Build only variants whose name matches this pattern (`*`, `?`) and keep the rest of the folder; may be repeated. Default: all
    /// variants.
    #[arg(long, value_name = "GLOB")]
    variant: Vec<String>,
    /// Build only these targets, separated by commas, and keep the rest of the folder. Function forms come with their language's
    /// target. Default: the targets of the plan.
    #[arg(long, value_name = "T,…", value_delimiter = ',')]
    target: Vec<String>,
    /// Number of threads, at most 1024. Default: one for each core.
    #[arg(long, value_name = "N", value_parser = jobs)]
    jobs: Option<usize>,
    #[command(flatten)]
    memory: MemoryArgs,
    /// Do not use the cache of finished tables. They are kept in the folder of temporary files instead (TMPDIR), without a name.
    #[arg(long)]
    no_cache: bool,
}

/// A number of threads. Each takes memory, and far more than there are cores only take turns.
fn jobs(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|number| (1..=1024).contains(number));
    number.ok_or_else(|| "expected a number of threads from 1 to 1024".to_owned())
}

/// What a run builds.
#[derive(Clone, Debug)]
pub(crate) struct Selection {
    /// In the order of the plan.
    pub(crate) variants: Vec<Variant>,
    /// In the order of the plan or of the command line.
    pub(crate) targets: Vec<Target>,
    /// Whether the selection is the whole plan. Otherwise the package is laid over the folder's content.
    pub(crate) is_whole: bool,
    /// Folder of the cache, if there is to be one.
    pub(crate) cache: Option<PathBuf>,
    /// Bytes of memory that may be taken.
    pub(crate) memory: u64,
    /// Hash of this program, if a folder that already has the package may be left unchanged.
    pub(crate) program: Option<String>,
}

pub(crate) fn run(args: &Args, caches: &Path, console: &Console) -> Result<Outcome> {
    run_with(args, caches, console, |plan, selection, out| build(plan, selection, out, console))
}

/// The sealed package of a selection. A partial package is laid over the folder's content. `None`: the folder has it already.
fn build(
    plan: &Plan,
    selection: &Selection,
    out: &Path,
    console: &Console,
) -> Result<Option<Package>> {
    let mut compiler = Compiler::new(plan)
        .variants(&selection.variants)
        .targets(&selection.targets)
        .memory_budget(selection.memory);
    if let Some(cache) = &selection.cache {
        compiler = compiler.cache(cache);
    }
    if !selection.is_whole {
        compiler = compiler.rest_from(out);
    }
    let expected = match (&selection.program, &selection.cache) {
        (Some(program), Some(cache)) => Expected::new(&compiler, plan, cache, out, program)?,
        _ => None,
    };
    if let Some(stamp) = expected.as_ref().and_then(|expected| expected.unchanged(out)) {
        stamp.notes.iter().for_each(|note| console.note(note));
        let mib = stamp.bytes as f64 / f64::from(1 << 20);
        let (out, files) = (out.display(), stamp.file_count());
        console.note(&format!("{out}: {files} files, {mib:.1} MiB, unchanged"));
        return Ok(None);
    }
    let bar = progress::bar(plan.surfaces.len() * selection.variants.len(), "generating");
    let baked = AtomicUsize::new(0);
    let show = |step: Step<'_>| match step {
        Step::Finished(_) => {
            baked.store(0, Ordering::Relaxed);
            bar.set_message("generating");
            bar.inc(1);
        }
        Step::Baked { label, columns, of } => {
            let sum = baked.fetch_add(columns, Ordering::Relaxed) + columns;
            bar.set_message(format!("baking {label}, {} %", 100 * sum / of.max(1)));
        }
        Step::NotCached(error) => bar.suspend(|| {
            console.note(&format!(
                "the cache takes nothing, so the next run will be as slow: {error}"
            ));
        }),
    };
    let package = compiler.progress(&show).compile();
    bar.finish_and_clear();
    let package = package?;
    package.notes().iter().for_each(|note| console.note(note));
    if let Some(expected) = expected {
        // the stamp may be written before the files: it states what they must contain
        expected.keep(&Stamp::new(&package, expected.inputs.clone(), package.notes().to_vec())?);
    }
    Ok(Some(package))
}

/// `build` makes the sealed package of a selection; `None` if the folder has it already.
fn run_with(
    args: &Args,
    caches: &Path,
    console: &Console,
    build: impl FnOnce(&Plan, &Selection, &Path) -> Result<Option<Package>> + Send,
) -> Result<Outcome> {
    interrupt::full_disk_is_an_error()?;
    let cancel = interrupt::install()?;
    let plan = args.plan.read(console)?;
    let program = unchanged::program();
    let cache = program.as_deref().filter(|_| !args.no_cache);
    let cache = cache.map(|program| unchanged::cache(caches, program));
    let mut selection = select(args, &plan, cache)?;
    if selection.is_whole && !args.check {
        selection.program = program;
    }
    // before anything of the folder is read, so that what is found there stays until the end
    let waiting = |text: &str| console.note(text);
    let (reading, output) = match args.check {
        true => (Some(FolderLock::take(&args.out, Access::Read, &waiting)?), None),
        false => (None, Some(Output::open(&args.out, GENERATED_BY, &cancel, &waiting)?)),
    };
    let threads = args.jobs.unwrap_or(0);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .context("threads cannot be started")?;
    let Some(package) = pool.install(|| build(&plan, &selection, &args.out))? else {
        return Ok(Outcome::Done);
    };
    let Some(output) = output else {
        let report = package::check(&package, &args.out)?;
        drop(reading);
        console.data(&spoken(&stale_text(&report, args)))?;
        return Ok(if report.is_stale() { Outcome::Findings } else { Outcome::Done });
    };
    let written = match output.write(&package) {
        Err(_) if cancel.is_cancelled() => interrupt::exit(),
        other => other?,
    };
    written.left_behind.iter().for_each(|left| console.note(&left.to_string()));
    let mib = written.bytes as f64 / f64::from(1 << 20);
    let (out, files) = (args.out.display(), written.files);
    console.note(&format!("{out}: {files} files, {mib:.1} MiB"));
    console.note(&format!(
        "next: cargo xtask validate {}; cargo xtask list prints the cost of each variant",
        shell_path(&args.out)
    ));
    Ok(Outcome::Done)
}

fn select(args: &Args, plan: &Plan, cache: Option<PathBuf>) -> Result<Selection> {
    let targets: Vec<Target> =
        args.target.iter().map(|word| Target::parse(word)).collect::<Result<_, _>>()?;
    Ok(Selection {
        variants: plan.select(&args.variant)?,
        is_whole: args.variant.is_empty() && targets.is_empty(),
        targets: if targets.is_empty() { plan.targets.clone() } else { targets },
        cache,
        memory: args.memory.budget(),
        program: None,
    })
}

fn stale_text(report: &Report, args: &Args) -> String {
    let groups = [
        ("changed", &report.changed),
        ("missing", &report.missing),
        ("orphan", &report.orphan),
        ("foreign", &report.foreign),
    ];
    let lines = groups
        .iter()
        .flat_map(|(what, paths)| paths.iter().map(move |path| format!("{what} {path}\n")));
    let mut text: String = lines.collect();
    if report.line_ends > 0 {
        text += &format!(
            "{} of the changed files have other line ends (CR LF) and no other difference: keep the package's .gitattributes, \
             which stops git from changing them\n",
            report.line_ends
        );
    }
    if report.is_stale() {
        let (plan, out) = (shell_path(&args.plan.plan), shell_path(&args.out));
        text += &format!("to mend: cargo xtask generate --plan {plan} --out {out}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use clap::Parser;
    use diffraction_shaders::package::Equality;

    use super::*;
    use crate::console::MessageFormat;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    const PLAN: &str = "schema = 1\n[[surface]]\nname = \"a\"\ngrating = { kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 100 }\n";

    /// Nothing is kept there by these tests.
    fn caches() -> PathBuf {
        std::env::temp_dir().join("diffraction-shaders")
    }

    fn names(_: &Plan, selection: &Selection, _: &Path) -> Result<Option<Package>> {
        let mut package = Package::new();
        for variant in &selection.variants {
            package.insert(
                &format!("{}.txt", variant.name),
                variant.canonical(),
                Equality::Bytes,
            )?;
        }
        package.seal(BTreeMap::new())?;
        Ok(Some(package))
    }

    #[test]
    fn a_package_is_written_then_checks_clean_until_it_is_edited() {
        let base = tempfile::tempdir().unwrap();
        let (plan, out) = (base.path().join("plan.toml"), base.path().join("out"));
        fs::write(&plan, PLAN).unwrap();
        let console = Console::new(MessageFormat::Human);
        let line = |more: &[&str]| {
            let plain =
                ["generate", "--plan", plan.to_str().unwrap(), "--out", out.to_str().unwrap()];
            run_with(&Line::parse_from(plain.iter().chain(more)).args, &caches(), &console, names)
        };
        assert_eq!(line(&["--check"]).unwrap(), Outcome::Findings);
        assert_eq!(line(&["--jobs", "1"]).unwrap(), Outcome::Done);
        assert_eq!(line(&["--check"]).unwrap(), Outcome::Done);
        fs::write(out.join("full-taylor-t31.txt"), "edited").unwrap();
        assert_eq!(line(&["--check"]).unwrap(), Outcome::Findings);
        fs::write(out.join("mine"), "mine").unwrap();
        assert_eq!(line(&["--variant", "*", "--target", "wgsl,spirv"]).unwrap(), Outcome::Done);
        assert!(out.join("mine").exists());
        assert!(line(&["--target", "dxil"]).is_err());
        assert!(line(&["--variant", "none"]).is_err());
    }

    /// Run by the tests below in a process of its own: writes a package of many files, without end if asked to.
    #[test]
    fn child() {
        let Ok(base) = std::env::var("GENERATE_TEST_BASE") else { return };
        let forever = std::env::var_os("GENERATE_TEST_FOREVER").is_some();
        let (plan, out) = (format!("{base}/plan.toml"), format!("{base}/out"));
        let args = Line::parse_from(["generate", "--plan", &plan, "--out", &out]).args;
        loop {
            let done =
                run_with(&args, &caches(), &Console::new(MessageFormat::Human), |_, _, _| {
                    let mut package = Package::new();
                    for i in 0..200 {
                        package.insert(
                            &format!("part/{i}"),
                            vec![b'b'; 20_000],
                            Equality::Bytes,
                        )?;
                    }
                    package.seal(BTreeMap::new())?;
                    Ok(Some(package))
                });
            let outcome = done.map_err(|error| format!("{error:#}"));
            assert_eq!(outcome, Ok(Outcome::Done));
            if !forever {
                return;
            }
        }
    }

    #[cfg(unix)]
    fn child_in(base: &Path, shell: &str) -> std::process::Command {
        let mut command = std::process::Command::new("sh");
        command.args([
            "-c",
            &format!("{shell} exec \"$0\" --exact generate::tests::child --nocapture"),
        ]);
        command.arg(std::env::current_exe().unwrap()).env("GENERATE_TEST_BASE", base);
        command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
        command
    }

    #[cfg(unix)]
    fn begun(base: &Path) -> PathBuf {
        fs::write(base.join("plan.toml"), PLAN).unwrap();
        let (plan, out) = (base.join("plan.toml"), base.join("out"));
        let line = ["generate", "--plan", plan.to_str().unwrap(), "--out", out.to_str().unwrap()];
        let console = Console::new(MessageFormat::Human);
        run_with(&Line::parse_from(line).args, &caches(), &console, names).unwrap();
        out
    }

    #[cfg(unix)]
    #[test]
    fn a_full_disk_is_an_error_and_the_previous_output_stays() {
        let base = tempfile::tempdir().unwrap();
        let out = begun(base.path());
        let before = fs::read(out.join("manifest.json")).unwrap();
        let done = child_in(base.path(), "ulimit -f 8;").output().unwrap();
        let text = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.code().is_some(), "killed by a signal: {:?}", done.status);
        assert!(text.contains("cannot be written: File too large"), "{text}");
        assert_eq!(fs::read(out.join("manifest.json")).unwrap(), before);
        assert_eq!(fs::read_dir(base.path()).unwrap().count(), 2, "the plan and the output");
    }

    #[cfg(unix)]
    #[test]
    fn an_interrupt_leaves_a_whole_output_and_nothing_else() {
        for (round, signal) in ["INT", "TERM", "INT", "TERM"].into_iter().enumerate() {
            let base = tempfile::tempdir().unwrap();
            let out = begun(base.path());
            let child =
                child_in(base.path(), "").env("GENERATE_TEST_FOREVER", "1").spawn().unwrap();
            while !out.join("part/0").exists() {
                std::thread::sleep(std::time::Duration::from_millis(2));
            }
            std::thread::sleep(std::time::Duration::from_millis(7 * round as u64));
            let kill = format!("kill -{signal} {}", child.id());
            assert!(
                std::process::Command::new("sh").args(["-c", &kill]).status().unwrap().success()
            );
            let done = child.wait_with_output().unwrap();
            assert_eq!(done.status.code(), Some(130), "{}", String::from_utf8_lossy(&done.stderr));
            assert_eq!(fs::read_dir(out.join("part")).unwrap().count(), 200);
            assert!(out.join("manifest.json").exists());
            assert_eq!(fs::read_dir(base.path()).unwrap().count(), 2, "the plan and the output");
        }
    }
}
