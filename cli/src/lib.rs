//! The commands of the compiler, and what all commands share: flags, messages, progress, signals.
//!
//! It is a crate of its own because a library's users must not compile an argument parser, and because an installed program
//! must not be called `xtask`. Two programs are made of it: `diffraction`, which works in any folder, and `cargo xtask`.
//!
//! One file per command, with `Args` (flags and help) and `run`; this file parses, dispatches and turns the outcome into an
//! exit code: 0 done, 1 findings, 2 usage, configuration, input or internal error. Commands that need drivers, browsers or
//! other programs are those of the harness, another program, which takes the place of this one ([`harness`]).

pub mod args;
pub mod console;
pub mod eval;
mod explain;
pub mod files;
mod generate;
pub mod harness;
mod inspect;
pub mod interrupt;
pub mod list;
pub mod program;
pub mod progress;
pub mod render;
pub mod replace;
pub mod runners;
mod unchanged;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};

use console::{Console, MessageFormat};

/// From a height field to validated diffraction shaders.
#[derive(Parser)]
#[command(version)]
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
    /// Show generated text beside the template lines that it came from.
    Explain(explain::Args),
    /// Print colours for given directions.
    Eval(eval::Args),
    /// Draw a BRDF map: all viewing directions under one light.
    Render(render::Args),
}

/// All commands in the order of the help text, those of the harness and of programs' own among them.
const ORDER: [&str; 15] = [
    "generate",
    "list",
    "inspect",
    "validate",
    "explain",
    "eval",
    "render",
    "compare",
    "testbench",
    "bench",
    "tune",
    "scene",
    "report",
    "serve",
    "test",
];

/// How a command ended that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
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

/// A program that has these commands.
#[derive(Clone, Copy, Debug)]
pub struct Program {
    /// What its users type, as in `cargo xtask generate`.
    pub name: &'static str,
    /// The folder that keeps finished tables.
    pub cache: fn() -> PathBuf,
    /// Finds the program of the harness, or builds it.
    pub harness: fn() -> Result<PathBuf>,
    /// A command that only this program has.
    pub own: Option<Own>,
}

/// A command that only one program has.
#[derive(Clone, Copy, Debug)]
pub struct Own {
    /// Its flags and help.
    pub command: fn() -> clap::Command,
    /// Runs it; its exit code.
    pub run: fn(&ArgMatches) -> Result<ExitCode>,
}

/// Runs the command of this process's arguments.
pub fn main(program: &Program) -> ExitCode {
    program::set_name(program.name);
    let args: Vec<OsString> = std::env::args_os().collect();
    if harness::is_asked(&args) {
        let error = harness::take_over(program, &args);
        return finish(Err(error), &Console::new(harness::message_format(&args)));
    }
    let matches = command(program).try_get_matches_from(&args).unwrap_or_else(|e| e.exit());
    if let (Some(own), Some((name, matches))) = (program.own, matches.subcommand())
        && (own.command)().get_name() == name
    {
        let format = matches.get_one("message_format").copied();
        let console = Console::new(format.unwrap_or(MessageFormat::Human));
        return finish((own.run)(matches), &console);
    }
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let console = Console::new(cli.message_format);
    let drivers = runners::none;
    let outcome = match cli.command {
        Command::Generate(args) => generate::run(&args, &(program.cache)(), &console),
        Command::List(args) => list::run(&args, &console),
        Command::Inspect(args) => inspect::run(&args, &console),
        Command::Explain(args) => explain::run(&args, &console),
        Command::Eval(ref with) if with.runner.runner.is_driver() => {
            Err(harness::take_over(program, &args))
        }
        Command::Eval(args) => eval::run(&args, &console, drivers),
        Command::Render(ref with) if with.runner.runner.is_driver() => {
            Err(harness::take_over(program, &args))
        }
        Command::Render(args) => render::run(&args, &console, drivers),
    };
    finish(outcome.map(ExitCode::from), &console)
}

/// The exit code of a command; why it failed goes to the console.
pub fn finish(outcome: Result<ExitCode>, console: &Console) -> ExitCode {
    match outcome {
        Ok(code) => code,
        Err(error) if console::is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            console.error(&error);
            ExitCode::from(2)
        }
    }
}

/// All commands of a program, those of the harness by name only.
fn command(program: &Program) -> clap::Command {
    let mut all = Cli::command();
    for (name, about) in harness::COMMANDS {
        all = all.subcommand(clap::Command::new(name).about(about));
    }
    if let Some(own) = program.own {
        all = all.subcommand((own.command)());
    }
    for (place, name) in ORDER.into_iter().enumerate() {
        if all.find_subcommand(name).is_some() {
            all = all.mut_subcommand(name, |command| command.display_order(place));
        }
    }
    program::named(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROGRAM: Program = Program {
        name: "cargo xtask",
        cache: PathBuf::new,
        harness: harness::installed,
        own: None,
    };

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

    #[test]
    fn help_lists_every_command_in_order() {
        let help = command(&PROGRAM).render_help().to_string();
        let places: Vec<Option<usize>> = ORDER
            .iter()
            .filter(|name| **name != "test")
            .map(|name| help.find(&format!("\n  {name} ")))
            .collect();
        assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{help}");
    }
}
