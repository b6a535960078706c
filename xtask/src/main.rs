//! Command line of diffraction-shaders.

mod test;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Command line of diffraction-shaders.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Test(test::Args),
}

fn main() -> anyhow::Result<ExitCode> {
    match Cli::parse().command {
        Command::Test(args) => test::run(&args),
    }
}
