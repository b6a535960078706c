//! The commands of the compiler, and what all commands share: options, messages, progress, signals.
//!
//! This is a crate of its own, because users of the library must not have to compile an argument parser, and because an
//! installed program must not be called `xtask`. Two programs use it: `diffraction`, which works in any folder, and `cargo xtask`.
//!
//! Each command has one file, with `Args` (options and help) and `run`. This file parses, dispatches and turns the outcome
//! into an exit code: 0 done, 1 findings, 2 usage, configuration, input or internal error. Commands that need drivers,
//! browsers or other programs belong to the harness, another program, which replaces this process ([`harness`]).

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
mod material;
pub mod memory;
mod pattern;
pub mod program;
pub mod progress;
pub mod render;
pub mod replace;
pub mod runners;
mod studio;
mod unchanged;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use diffraction_shaders::error::Error;

use console::{Console, MessageFormat};

/// Compile height fields (scans or gratings) to diffraction shaders with a stated error.
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
    /// Build a package of shaders, tables and manifests from a plan.
    Generate(generate::Args),
    /// List surfaces, variants and targets of a plan, what each variant costs, and what was rejected and why.
    List(list::Args),
    /// Show the facts of a surface (size, heights, periods, terms needed, costs) and draw it.
    Inspect(inspect::Args),
    /// Print the plan's keys for the materials of a glTF file: metals, dielectrics, coats, thin films.
    Material(material::Args),
    /// Show a variant's generated shader beside the template lines that it came from.
    Explain(explain::Args),
    /// Print the colours for given directions of light and viewer.
    Eval(eval::Args),
    /// Draw a BRDF map: the colours of all viewing directions under one light.
    Render(render::Args),
    /// Write a panorama by formula, a studio or a sky, to light surfaces and engines with.
    Studio(studio::Args),
    /// Draw a pattern map for a foil (angle, period, depth and mask per texel) as a PNG file, with a preview.
    Pattern(pattern::Args),
}

/// All commands in the order of the help text, with those of the harness and those that only one program has.
const ORDER: [&str; 19] = [
    "generate",
    "list",
    "import",
    "material",
    "inspect",
    "validate",
    "explain",
    "eval",
    "render",
    "studio",
    "pattern",
    "compare",
    "testbench",
    "bench",
    "tune",
    "scene",
    "report",
    "serve",
    "test",
];

/// How a command ended, unless it failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Done,
    /// Exit code 1: the output is stale, an error is over its tolerance, or a validation failed.
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
    /// What users type before the command, as in `cargo xtask generate`.
    pub name: &'static str,
    /// The folder that caches finished tables.
    pub cache: fn() -> PathBuf,
    /// Finds or builds the harness's program.
    pub harness: fn() -> Result<PathBuf>,
    /// A command that only this program has.
    pub own: Option<Own>,
}

/// A command that only one program has.
#[derive(Clone, Copy, Debug)]
pub struct Own {
    /// Its options and help.
    pub command: fn() -> clap::Command,
    /// Runs it and returns its exit code.
    pub run: fn(&ArgMatches) -> Result<ExitCode>,
}

/// Runs the command that this process's arguments name.
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
    if let Err(error) = interrupt::watch() {
        return finish(Err(error), &console);
    }
    let outcome = match cli.command {
        Command::Generate(args) => generate::run(&args, &(program.cache)(), &console),
        Command::List(args) => list::run(&args, &console),
        Command::Inspect(args) => inspect::run(&args, &console),
        Command::Material(args) => material::run(&args, &console),
        Command::Explain(args) => explain::run(&args, &console),
        Command::Eval(ref with) if with.runner.runner.is_driver() => {
            Err(harness::take_over(program, &args))
        }
        Command::Eval(args) => eval::run(&args, &console, drivers),
        Command::Render(ref with) if with.runner.runner.is_driver() => {
            Err(harness::take_over(program, &args))
        }
        Command::Render(args) => render::run(&args, &console, drivers),
        Command::Studio(args) => studio::run(&args, &console),
        Command::Pattern(args) => pattern::run(&args, &console),
    };
    finish(outcome.map(ExitCode::from), &console)
}

/// The exit code of a command. An error is printed on the console.
pub fn finish(outcome: Result<ExitCode>, console: &Console) -> ExitCode {
    match outcome {
        Ok(code) => code,
        Err(error) if console::is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            console.error(&error);
            let finding = error.chain().filter_map(|cause| cause.downcast_ref::<Error>());
            ExitCode::from(if { finding }.any(Error::is_finding) { 1 } else { 2 })
        }
    }
}

/// All commands of a program. Those of the harness have only their names here.
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
