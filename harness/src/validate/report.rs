//! What validators said of a folder.

use std::path::PathBuf;

use diffraction_shaders::diagnostic::Diagnostic;
use serde::Serialize;

use super::Trouble;

/// The results of the tools for a folder.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// One line per tool, in the order given.
    pub tools: Vec<ToolReport>,
    /// Rejected files, in order of tools, then paths.
    pub failures: Vec<Failure>,
    /// Shader files that no tool read.
    pub unread: Vec<Unread>,
}

impl Report {
    /// Whether every tool that ran accepted all its files, each answered, and at least one file was read.
    pub fn accepted(&self) -> bool {
        self.failures.is_empty()
            && self.silent().next().is_none()
            && self.tools.iter().any(|tool| tool.files > 0)
    }

    /// The failures as diagnostics without a place, then the tools that did not answer.
    pub fn diagnostics(&self) -> Vec<Diagnostic> {
        let rejected = self.failures.iter().map(|failure| {
            let message = format!("{}: rejected by {}", failure.file.display(), failure.tool);
            Diagnostic::error(message).note(&failure.message)
        });
        let silent = self.silent().map(|(tool, trouble)| {
            let message = format!("{}: {trouble}; {} files not checked", tool.name, tool.skipped);
            Diagnostic::error(message).help("run it by hand, or give it more time: --time-limit")
        });
        rejected.chain(silent).collect()
    }

    /// Tools that did not answer in time.
    fn silent(&self) -> impl Iterator<Item = (&ToolReport, &Trouble)> {
        self.tools.iter().filter_map(|tool| match &tool.trouble {
            Some(trouble @ Trouble::NotAnswering(_)) => Some((tool, trouble)),
            _ => None,
        })
    }
}

/// A shader file that no tool read.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Unread {
    /// Path relative to the folder.
    pub file: PathBuf,
    /// The reason.
    pub reason: String,
}

/// One line of the table of tools.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ToolReport {
    /// Name of the tool.
    pub name: String,
    /// Its version; `None` if it cannot run.
    pub version: Option<String>,
    /// Why it gave no verdict, or no further one.
    pub trouble: Option<Trouble>,
    /// Number of files that it read.
    pub files: usize,
    /// Number of files that it rejected.
    pub rejected: usize,
    /// Number of files that it was to read and did not, since it gave no answer on one of them.
    pub skipped: usize,
    /// Number of files whose shaders it executed, and the greatest error of their probes in tolerances.
    pub executed: Option<(usize, f64)>,
}

/// A file that a tool rejected.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Failure {
    /// Path relative to the folder.
    pub file: PathBuf,
    /// Name of the tool.
    pub tool: String,
    /// The tool's message.
    pub message: String,
}
