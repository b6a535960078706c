//! Licences, sources and banned crates of all dependencies, checked by cargo-deny with the rules of `deny.toml`.
//!
//! What needs a list from outside, the advisories, is no part of it; CONTRIBUTING.md says how to check them.

use std::path::{Path, PathBuf};

use super::modules::call;
use super::setup::Outcome;

/// The version that is installed. Its own lock file fixes what it is built from.
const VERSION: &str = "0.20.2";

/// Arguments of the check.
pub const ARGUMENTS: &str = "--locked check --hide-inclusion-graph licenses bans sources";

/// Installs cargo-deny below `target/tools`, unless it is there.
pub fn install(root: &Path) -> anyhow::Result<Outcome> {
    if program(root).is_file() {
        return Ok(Outcome::Ready);
    }
    let folder = folder();
    let arguments =
        ["install", "cargo-deny", "--version", VERSION, "--locked", "--root", folder.as_str()];
    if !call(root, "cargo", arguments)? {
        eprintln!("cargo-deny {VERSION} cannot be installed; fix that, or pass --no-setup");
        return Ok(Outcome::Missing);
    }
    Ok(Outcome::Ready)
}

/// Where the program is once it is installed.
pub fn program(root: &Path) -> PathBuf {
    root.join(folder()).join("bin/cargo-deny").with_extension(std::env::consts::EXE_EXTENSION)
}

fn folder() -> String {
    format!("target/tools/cargo-deny-{VERSION}")
}
