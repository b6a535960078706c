//! `cargo xtask test`: installs what the tests need, then runs all checks and tests.

mod deny;
mod modules;
mod setup;

use std::{
    ffi::{OsStr, OsString},
    path::{Path, PathBuf},
    process::{Command, ExitCode},
    time::{Duration, Instant},
};

use crate::root;

/// Install what the tests need, then run all checks and tests.
///
/// Missing packages (software drivers, validators, Chromium, node, Python) are installed with apt-get, if that needs no password.
/// npm installs the gallery's libraries, and pip those of the Python example, of `import` and of `validate`, all into folders of
/// the workspace. cargo-deny is built there, too. Then formatting, lints, documentation, tests and the check of dependencies run, all
/// of them even if one fails.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cargo xtask test
  cargo xtask test -- --test drivers       run only the tests of harness/tests/drivers
  cargo xtask test --no-setup -- -- bands  run only tests whose name contains `bands`

Exit code 0: all steps passed. 1: a step failed. 2: a step could not run, or a tool is missing.")]
pub struct Args {
    /// Do not install anything. Tests without their tool then print a note and pass
    #[arg(long)]
    pub no_setup: bool,
    /// Further arguments for `cargo test`, after --
    #[arg(last = true, value_name = "ARGS")]
    pub cargo_test: Vec<OsString>,
}

/// Runs the command. 0: all steps passed. 1: a step failed. 2: a step could not run, or a tool is missing.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let root = root();
    let begun = Instant::now();
    if !args.no_setup
        && let setup::Outcome::Missing = setup::run(root)?
    {
        return Ok(ExitCode::from(2));
    }
    let mut done = vec![Done { name: "setup", outcome: Outcome::Passed, time: begun.elapsed() }];
    for step in steps(root, &args.cargo_test) {
        let program = step.program.file_name().unwrap_or(step.program.as_os_str());
        let arguments = step.arguments.join(OsStr::new(" "));
        eprintln!("\n== {}: {} {}", step.name, program.display(), arguments.display());
        let begun = Instant::now();
        let status = step.command(root, !args.no_setup).status();
        let outcome = match status {
            Ok(status) if status.success() => Outcome::Passed,
            Ok(_) => Outcome::Failed,
            Err(e) => {
                eprintln!("{}: {} cannot be started: {e}", step.name, program.display());
                Outcome::NotRun
            }
        };
        done.push(Done { name: step.name, outcome, time: begun.elapsed() });
    }
    eprintln!();
    for Done { name, outcome, time } in &done {
        eprintln!("{name:<20} {:<10} {:7.1} s", outcome.word(), time.as_secs_f64());
    }
    eprintln!("{:<31} {:7.1} s", "together", begun.elapsed().as_secs_f64());
    Ok(ExitCode::from(exit_code(&done)))
}

/// One call of a program.
struct Step {
    name: &'static str,
    program: PathBuf,
    arguments: Vec<OsString>,
    environment: &'static [(&'static str, &'static str)],
}

impl Step {
    fn command(&self, root: &Path, tools_required: bool) -> Command {
        let mut command = Command::new(&self.program);
        command.args(&self.arguments).current_dir(root).envs(self.environment.iter().copied());
        if tools_required {
            command.env("DIFFRACTION_REQUIRE_TOOLS", "1");
        }
        command
    }
}

/// The steps. All of cargo except formatting share one profile and all crates, so that each dependency is built once.
fn steps(root: &Path, cargo_test: &[OsString]) -> Vec<Step> {
    let shared = "--release --workspace";
    let cargo = PathBuf::from(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let step = |name, command: &str, rest: &str| Step {
        name,
        program: cargo.clone(),
        arguments: format!("{command} {rest}").split_whitespace().map(OsString::from).collect(),
        environment: &[],
    };
    let mut build = step("build of the tests", "test", &format!("{shared} --no-run"));
    build.arguments.extend(cargo_test.iter().take_while(|word| *word != "--").cloned());
    let mut test = step("tests", "test", &format!("{shared} --no-fail-fast"));
    test.arguments.extend_from_slice(cargo_test);
    test.environment = &[
        // Mesa's GL renders to 32-bit float targets only with this
        ("MESA_EXTENSION_OVERRIDE", "+GL_ARB_color_buffer_float"),
        // otherwise Mesa's Vulkan looks for a Wayland display and prints a warning
        ("NODEVICE_SELECT", "1"),
    ];
    let mut doc = step("documentation", "doc", &format!("{shared} --no-deps"));
    doc.environment = &[("RUSTDOCFLAGS", "-D warnings")];
    let dependencies =
        Step { program: deny::program(root), ..step("dependencies", "", deny::ARGUMENTS) };
    // without the setup it may be missing
    let dependencies = dependencies.program.is_file().then_some(dependencies);
    let own = [
        step("formatting", "fmt", "--all -- --check"),
        step("lints", "clippy", &format!("{shared} --all-targets -- -D warnings")),
        doc,
        build,
        test,
    ];
    own.into_iter().chain(dependencies).collect()
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Outcome {
    Passed,
    Failed,
    NotRun,
}

impl Outcome {
    fn word(self) -> &'static str {
        match self {
            Outcome::Passed => "passed",
            Outcome::Failed => "failed",
            Outcome::NotRun => "not run",
        }
    }
}

struct Done {
    name: &'static str,
    outcome: Outcome,
    time: Duration,
}

/// The exit code of the first step that did not pass.
fn exit_code(done: &[Done]) -> u8 {
    done.iter()
        .find_map(|done| match done.outcome {
            Outcome::Passed => None,
            Outcome::Failed => Some(1),
            Outcome::NotRun => Some(2),
        })
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_step_that_does_not_pass_decides() {
        let done = |outcomes: &[Outcome]| -> Vec<Done> {
            let done =
                |outcome: &Outcome| Done { name: "", outcome: *outcome, time: Duration::ZERO };
            outcomes.iter().map(done).collect()
        };
        use Outcome::{Failed, NotRun, Passed};
        assert_eq!(exit_code(&done(&[Passed, Passed])), 0);
        assert_eq!(exit_code(&done(&[Passed, Failed, NotRun])), 1);
        assert_eq!(exit_code(&done(&[NotRun, Failed])), 2);
    }

    #[test]
    fn a_second_pair_of_dashes_reaches_the_tests() {
        #[derive(clap::Parser)]
        struct Cli {
            #[command(flatten)]
            args: Args,
        }
        let cli = <Cli as clap::Parser>::parse_from(["test", "--", "--test", "gpu", "--", "bands"]);
        assert_eq!(cli.args.cargo_test, ["--test", "gpu", "--", "bands"]);
        let cli = <Cli as clap::Parser>::parse_from(["test", "--no-setup", "--", "--", "bands"]);
        assert_eq!(cli.args.cargo_test, ["--", "bands"]);
    }

    #[test]
    fn further_arguments_go_to_cargo_test() {
        let steps = steps(Path::new("."), &["--test".into(), "gpu".into()]);
        let with: Vec<_> = steps
            .iter()
            .filter(|s| s.arguments.contains(&"--workspace".into()))
            .map(|s| s.name)
            .collect();
        assert_eq!(with, ["lints", "documentation", "build of the tests", "tests"]);
        assert!(steps[4].arguments.ends_with(&["--test".into(), "gpu".into()]));
    }
}
