//! The commands of the harness's program.
//!
//! Each command has one file, as in `diffraction_cli`. Options, messages and exit codes are shared with that crate.

mod bench;
mod compare;
mod digits;
mod drivers;
mod import;
mod report;
mod restart;
mod scene;
mod serve;
mod setup;
mod testbench;
mod tune;
mod validate;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use diffraction_cli::console::{Console, MessageFormat};
use diffraction_cli::{eval, finish, harness, interrupt, program, render};

/// Compare, time and validate diffraction shaders on the drivers of this machine.
#[derive(Parser)]
#[command(version)]
struct Cli {
    /// Format of errors and notes on stderr.
    #[arg(long, global = true, value_enum, default_value_t = MessageFormat::Human)]
    message_format: MessageFormat,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Convert files of instruments to Gwyddion Simple Field, which plans read.
    Import(import::Args),
    /// Check every emitted shader with external validators.
    Validate(validate::Args),
    /// Print the colours for given directions of light and viewer.
    Eval(eval::Args),
    /// Draw a BRDF map: the colours of all viewing directions under one light.
    Render(render::Args),
    /// Compare the colours of every variant, by every route, with the exact reference, its twin and the other routes.
    Compare(compare::Args),
    /// Measure a surface's period from its response over wavelength and viewing angle.
    Testbench(testbench::Args),
    /// Measure the frame time of every variant on every adapter.
    Bench(bench::Args),
    /// Find the cheapest variant of a surface within an error budget.
    Tune(tune::Args),
    /// Draw a variant as the skin of a 3-D body: pictures, sweeps, a turntable.
    Scene(scene::Args),
    /// Show the results of compare, bench, testbench and tune on one HTML page.
    Report(report::Args),
    /// Serve the gallery to a browser on this machine.
    Serve(serve::Args),
}

/// Runs the command that this process's arguments name.
pub fn main() -> ExitCode {
    program::set_name(&std::env::var(program::CALLED_AS).unwrap_or_else(|_| harness::NAME.into()));
    let matches = program::named(Cli::command()).get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let console = Console::new(cli.message_format);
    if let Err(error) = interrupt::watch() {
        return finish(Err(error), &console);
    }
    let outcome = match cli.command {
        Command::Import(args) => import::run(&args, &console),
        Command::Validate(args) => validate::run(&args, &console),
        Command::Eval(args) => restart::with_drivers_for(&args.runner)
            .and_then(|()| eval::run(&args, &console, drivers::open)),
        Command::Render(args) => restart::with_drivers_for(&args.runner)
            .and_then(|()| render::run(&args, &console, drivers::open)),
        Command::Compare(args) => compare::run(&args, &console),
        Command::Testbench(args) => testbench::run(&args, &console),
        Command::Bench(args) => bench::run(&args, &console),
        Command::Tune(args) => tune::run(&args, &console),
        Command::Scene(args) => scene::run(&args, &console),
        Command::Report(args) => report::run(&args, &console),
        Command::Serve(args) => serve::run(&args, &console),
    };
    finish(outcome.map(ExitCode::from), &console)
}

#[cfg(test)]
mod tests {
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

    /// The other programs list these commands, but do not have them.
    #[test]
    fn the_list_of_the_other_programs_is_right() {
        let command = Cli::command();
        let of_both = ["eval", "render"];
        let own: Vec<(&str, String)> = command
            .get_subcommands()
            .map(|c| (c.get_name(), c.get_about().map(ToString::to_string).unwrap_or_default()))
            .filter(|(name, _)| !of_both.contains(name))
            .collect();
        assert_eq!(own, harness::COMMANDS.map(|(name, about)| (name, about.to_owned())));
    }
}
