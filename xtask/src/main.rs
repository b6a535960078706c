//! `cargo xtask`: all commands of the project, inside its workspace.
//!
//! The compiler's commands are in `diffraction_cli`, `test` is here. All others are passed to the harness's program, which is
//! built when it is first needed.

mod build;
mod test;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, FromArgMatches};
use diffraction_cli::{Own, Program};

fn main() -> ExitCode {
    let test = Own {
        command: || test::Args::augment_args(clap::Command::new("test")),
        run: |matches| test::run(&test::Args::from_arg_matches(matches)?),
    };
    let program = Program { name: "cargo xtask", cache, harness: build::harness, own: Some(test) };
    diffraction_cli::main(&program)
}

/// The workspace.
fn root() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().unwrap_or(own)
}

fn cache() -> PathBuf {
    root().join("target/tables")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_is_sound_and_has_an_example() {
        let command = test::Args::augment_args(clap::Command::new("test"));
        command.clone().debug_assert();
        let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        assert!(help.starts_with("Example") && help.contains("cargo xtask test"), "{help}");
    }
}
