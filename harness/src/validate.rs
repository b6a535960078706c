//! Checks emitted files with external validators.
//!
//! Every tool runs on the files in place. Function forms are put inside a shell that calls them. A tool that crashes or does
//! not end in time counts as having rejected its file.

mod reflect;
mod shell;
mod tools;

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use diffraction_shaders::diagnostic::Diagnostic;
use diffraction_shaders::error::{Error, Result};
use rayon::prelude::*;
use serde::Serialize;

pub use reflect::Reflection;
pub use tools::{External, HlslSpirv, Naga, tools};

/// Maximum time of a tool for one file.
const TIME_LIMIT: Duration = Duration::from_secs(60);

/// The language that a tool reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reads {
    /// WGSL.
    Wgsl,
    /// GLSL, GLSL ES and HLSL.
    GlslHlsl,
    /// HLSL.
    Hlsl,
    /// SPIR-V.
    Spirv,
}

impl Reads {
    pub(super) fn name(self, name: &str) -> bool {
        let suffixes: &[&str] = match self {
            Reads::Wgsl => &[".wgsl"],
            Reads::GlslHlsl => &[".glsl", ".es300.vert", ".es300.frag", ".hlsl"],
            Reads::Hlsl => &[".hlsl"],
            Reads::Spirv => &[".spv"],
        };
        suffixes.iter().any(|suffix| name.ends_with(suffix))
    }
}

/// A validator.
pub trait Tool: Send + Sync {
    /// Its name on the command line and in tables.
    fn name(&self) -> &str;

    /// The Debian package that contains it, if there is one.
    fn package(&self) -> Option<&str>;

    /// Its version, as far as it reports one; `None` if it cannot run here.
    fn version(&self) -> Option<String>;

    /// Whether it reads files of this name.
    fn reads(&self, name: &str) -> bool;

    /// Checks a file. The error is the tool's message.
    fn check(&self, file: &Path) -> Result<(), String>;
}

/// The results of the tools for a folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Report {
    /// One line per tool, in the order given.
    pub tools: Vec<ToolReport>,
    /// Rejected files, in order of tools, then paths.
    pub failures: Vec<Failure>,
    /// Shader files that no tool read.
    pub unread: Vec<Unread>,
}

impl Report {
    /// Whether every tool that ran accepted all its files, and at least one file was read.
    pub fn accepted(&self) -> bool {
        self.failures.is_empty() && self.tools.iter().any(|tool| tool.files > 0)
    }

    /// The failures as diagnostics without a place.
    pub fn diagnostics(&self) -> Vec<Diagnostic> {
        let describe = |failure: &Failure| {
            let message = format!("{}: rejected by {}", failure.file.display(), failure.tool);
            Diagnostic::error(message).note(&failure.message)
        };
        self.failures.iter().map(describe).collect()
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
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ToolReport {
    /// Name of the tool.
    pub name: String,
    /// Its version; `None` if it is not installed.
    pub version: Option<String>,
    /// Number of files that it read.
    pub files: usize,
    /// Number of files that it rejected.
    pub rejected: usize,
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

/// Runs the tools over every file below `folder`, in parallel.
///
/// Tools that are not installed are skipped and reported. A missing tool in `required` is an error, and so is an unknown name.
pub fn validate(folder: &Path, tools: &[Box<dyn Tool>], required: &[String]) -> Result<Report> {
    let versions: Vec<Option<String>> = tools.par_iter().map(|tool| tool.version()).collect();
    for name in required {
        let known = tools.iter().zip(&versions).find(|(tool, _)| tool.name() == name);
        match known {
            None => {
                let names: Vec<&str> = tools.iter().map(|tool| tool.name()).collect();
                return Err(Error::new(name, "is not a known validator")
                    .remedy(format_args!("one of {}", names.join(", "))));
            }
            Some((tool, None)) => {
                let error = Error::new(name, "is required, but not installed");
                return Err(match tool.package() {
                    Some(package) => error.remedy(format_args!("apt-get install {package}")),
                    None => error.remedy("put its program on the PATH"),
                });
            }
            Some((_, Some(_))) => {}
        }
    }
    let mut files = Vec::new();
    walk(folder, &mut files)?;
    files.sort();
    let mut jobs = Vec::new();
    let mut unread = BTreeSet::new();
    for file in &files {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let readers = tools.iter().enumerate().filter(|(_, tool)| tool.reads(&name));
        let before = jobs.len();
        jobs.extend(readers.filter(|(i, _)| versions[*i].is_some()).map(|(i, _)| (i, file)));
        if jobs.len() == before && is_shader(&name) {
            let reason = if name.ends_with(".metal") {
                "Metal's compiler exists on macOS only".to_owned()
            } else {
                let named = tools.iter().filter(|tool| tool.reads(&name)).map(|tool| tool.name());
                format!(
                    "needs one of these tools, none of which is installed: {}",
                    named.collect::<Vec<_>>().join(", ")
                )
            };
            unread.insert(Unread { file: relative(file, folder), reason });
        }
    }
    jobs.sort();
    let failures: Vec<(usize, Failure)> = jobs
        .par_iter()
        .filter_map(|&(index, file)| {
            let tool = &tools[index];
            let message = tool.check(file).err()?;
            let failure =
                Failure { file: relative(file, folder), tool: tool.name().to_owned(), message };
            Some((index, failure))
        })
        .collect();
    let rows = tools.iter().zip(versions).enumerate().map(|(index, (tool, version))| ToolReport {
        name: tool.name().to_owned(),
        version,
        files: jobs.iter().filter(|(i, _)| *i == index).count(),
        rejected: failures.iter().filter(|(i, _)| *i == index).count(),
    });
    Ok(Report {
        tools: rows.collect(),
        failures: failures.into_iter().map(|(_, failure)| failure).collect(),
        unread: unread.into_iter().collect(),
    })
}

fn relative(file: &Path, folder: &Path) -> PathBuf {
    file.strip_prefix(folder).unwrap_or(file).to_owned()
}

/// Whether a package's file of this name is a shader.
fn is_shader(name: &str) -> bool {
    let suffixes = [".wgsl", ".glsl", ".es300.vert", ".es300.frag", ".spv", ".hlsl", ".metal"];
    suffixes.iter().any(|suffix| name.ends_with(suffix))
}

/// Adds all files below a folder. Links are not followed.
fn walk(folder: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    let unreadable = |error| Error::new(folder.display(), "cannot be listed").source(error);
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let kind = entry.file_type().map_err(unreadable)?;
        if kind.is_dir() {
            walk(&entry.path(), files)?;
        } else if kind.is_file() {
            files.push(entry.path());
        }
    }
    Ok(())
}
