//! Why a validator gives no verdict.

use std::fmt;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use serde::Serialize;

use crate::process::{Fault, not_executable, on_path, run};

/// Why a tool gives no verdict.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub enum Trouble {
    /// It is not there.
    NotInstalled,
    /// A file of its name is there, which nobody may execute.
    NotExecutable(PathBuf),
    /// It accepted a file that is wrong, or refused one that is right; or it crashed.
    NotBelieved(String),
    /// It did not end in time.
    NotAnswering(String),
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Trouble::NotInstalled => f.write_str("not installed"),
            Trouble::NotExecutable(file) => write!(f, "not executable: {}", file.display()),
            Trouble::NotBelieved(why) => write!(f, "not believed: {why}"),
            Trouble::NotAnswering(why) => write!(f, "not answering: {why}"),
        }
    }
}

/// The program of this name on the PATH.
pub(super) fn program(name: &str) -> Result<PathBuf, Trouble> {
    on_path(name)
        .ok_or_else(|| not_executable(name).map_or(Trouble::NotInstalled, Trouble::NotExecutable))
}

/// The first line of what a program says of its version.
pub(super) fn version(command: &mut Command, limit: Duration) -> Result<String, Trouble> {
    match run(command, limit) {
        Err(fault @ Fault::TimedOut(_)) => Err(Trouble::NotAnswering(fault.to_string())),
        Err(fault) => Err(Trouble::NotBelieved(fault.to_string())),
        Ok((status, text)) => {
            let line = text.lines().map(str::trim).find(|line| !line.is_empty());
            let line = line.filter(|_| status.success()).unwrap_or("unknown version");
            Ok(line.chars().take(80).collect())
        }
    }
}
