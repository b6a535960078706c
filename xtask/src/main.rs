//! Command line of diffraction-shaders.
//!
//! One file per command, with `Args` (flags and help) and `run`; this file parses, dispatches and turns the outcome
//! into an exit code: 0 done, 1 findings, 2 usage, configuration, input or internal error.

mod args;
mod bench;
mod compare;
mod console;
mod eval;
mod explain;
mod files;
mod generate;
mod inspect;
mod interrupt;
mod list;
mod progress;
mod reexec;
mod render;
mod report;
mod runners;
mod scene;
mod serve;
mod test;
mod testbench;
mod tune;
mod unchanged;
mod validate;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use console::{Console, MessageFormat};

/// From a height field to validated diffraction shaders.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Cli {
    /// How diagnostics appear on stderr.
    #[arg(long, global = true, value_enum, default_value_t = MessageFormat::Human)]
    message_format: MessageFormat,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Turn a plan into a package of shaders, tables and manifests.
    Generate(generate::Args),
    /// Show surfaces, variants, targets, static cost, and what was rejected and why.
    List(list::Args),
    /// Show what a user asks first about a surface, and draw it.
    Inspect(inspect::Args),
    /// Run external validators over every emitted file.
    Validate(validate::Args),
    /// Show generated text beside the template lines that it came from.
    Explain(explain::Args),
    /// Print colours for given directions.
    Eval(eval::Args),
    /// Draw a BRDF map: all viewing directions under one light.
    Render(render::Args),
    /// Compare every variant by every route with the exact reference, its twin and the other routes.
    Compare(compare::Args),
    /// Measure a surface's period from the response over wavelength and viewing angle.
    Testbench(testbench::Args),
    /// Measure the time of every variant on every adapter.
    Bench(bench::Args),
    /// Find the cheapest variant of a surface within an error budget.
    Tune(tune::Args),
    /// Draw a variant on the skin of a body: stills, sweeps, a turntable.
    Scene(scene::Args),
    /// Show results of compare, bench and testbench on one HTML page.
    Report(report::Args),
    /// Serve the gallery to a browser on this machine.
    Serve(serve::Args),
    Test(test::Args),
}

/// How a command ended that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Exit code 0.
    Done,
    /// Exit code 1: stale output, over tolerance, failed validation.
    Findings,
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> ExitCode {
        match outcome {
            Outcome::Done => ExitCode::SUCCESS,
            Outcome::Findings => ExitCode::from(1),
        }
    }
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let console = Console::new(cli.message_format);
    let outcome = match cli.command {
        Command::Generate(args) => generate::run(&args, &console).map(ExitCode::from),
        Command::List(args) => list::run(&args, &console).map(ExitCode::from),
        Command::Inspect(args) => inspect::run(&args, &console).map(ExitCode::from),
        Command::Validate(args) => validate::run(&args, &console).map(ExitCode::from),
        Command::Explain(args) => explain::run(&args, &console).map(ExitCode::from),
        Command::Eval(args) => eval::run(&args, &console).map(ExitCode::from),
        Command::Render(args) => render::run(&args, &console).map(ExitCode::from),
        Command::Compare(args) => compare::run(&args, &console).map(ExitCode::from),
        Command::Testbench(args) => testbench::run(&args, &console).map(ExitCode::from),
        Command::Bench(args) => bench::run(&args, &console).map(ExitCode::from),
        Command::Tune(args) => tune::run(&args, &console).map(ExitCode::from),
        Command::Scene(args) => scene::run(&args, &console).map(ExitCode::from),
        Command::Report(args) => report::run(&args, &console).map(ExitCode::from),
        Command::Serve(args) => serve::run(&args, &console).map(ExitCode::from),
        Command::Test(args) => test::run(&args),
    };
    match outcome {
        Ok(code) => code,
        Err(error) if console::is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            console.error(&error);
            ExitCode::from(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn every_command_is_sound_and_has_an_example() {
        let mut command = Cli::command();
        command.build();
        command.clone().debug_assert();
        for command in command.get_subcommands().filter(|command| command.get_name() != "help") {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let call = format!("cargo xtask {}", command.get_name());
            assert!(
                help.starts_with("Example") && help.contains(&call),
                "{}: {help}",
                command.get_name()
            );
        }
    }
}
