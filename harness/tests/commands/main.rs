//! The commands of the program, as processes.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod command_bench;
mod command_compare;
mod command_import;
mod command_report;
mod command_scene;
mod command_testbench;
mod command_tune;
mod command_validate;
mod crashes;
mod endless;
mod interrupted;
mod program;

use std::path::Path;
use std::process::{Command, Output};

/// A folder with a plan.
fn folder_with(plan: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plan.toml"), plan).unwrap();
    folder
}

/// Runs the program in a folder.
fn run(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
    command.args(args).current_dir(folder).output().unwrap()
}

/// Whether a run found no driver; that fails if tools are required.
fn without_driver(done: &Output) -> bool {
    let text = String::from_utf8_lossy(&done.stderr);
    let missing = text.contains("no adapter");
    if missing {
        support::tools::missing(text);
    }
    missing
}
