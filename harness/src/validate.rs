//! Checks emitted files with external validators.
//!
//! Every tool runs on the files in place. Function forms are put inside a shell that calls them. A tool's verdicts count
//! once it has judged a small package of ours rightly, sound and spoilt. A tool that crashes on a file has rejected it; one
//! that does not end in time is asked no more.

mod control;
mod dxc;
mod files;
mod hlsl;
mod metal;
mod reflect;
mod report;
mod shell;
mod tools;
mod trouble;

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    sync::OnceLock,
    time::Duration,
};

use diffraction_shaders::error::{Error, Result};
use rayon::prelude::*;

use crate::process::Fault;

use files::{all_files, is_shader, name, relative};

pub use control::{Change, Control};
pub use dxc::Dxc;
pub use hlsl::HlslSpirv;
pub use metal::MetalCpu;
pub use reflect::Reflection;
pub use report::{Failure, Report, ToolReport, Unread};
pub use tools::{External, Naga, tools};
pub use trouble::Trouble;

/// Maximum time of a tool for one run, unless asked otherwise.
pub const TIME_LIMIT: Duration = Duration::from_secs(60);

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
    /// Metal.
    Metal,
}

impl Reads {
    pub(super) fn name(self, name: &str) -> bool {
        let suffixes: &[&str] = match self {
            Reads::Wgsl => &[".wgsl"],
            Reads::GlslHlsl => &[".glsl", ".es300.vert", ".es300.frag", ".hlsl"],
            Reads::Hlsl => &[".hlsl"],
            Reads::Spirv => &[".spv"],
            Reads::Metal => &[".metal"],
        };
        suffixes.iter().any(|suffix| name.ends_with(suffix))
    }

    /// A call of what nobody defines, in each text; in SPIR-V an instruction without a length.
    pub(super) fn controls(self) -> &'static [Control] {
        const GLSL: Control =
            Control::text("diffraction.frag.glsl", "vec3 tristimulus(", "vec3 tristimulvs(");
        const HLSL: Control =
            Control::text("diffraction.hlsl", "float3 tristimulus(", "float3 tristimulvs(");
        match self {
            Reads::Wgsl => {
                const { &[Control::text("diffraction.wgsl", "fn tristimulus(", "fn tristimulvs(")] }
            }
            Reads::GlslHlsl => const { &[GLSL, HLSL] },
            Reads::Hlsl => const { &[HLSL] },
            Reads::Spirv => {
                const FILE: &str = "diffraction.frag.spv";
                const { &[Control { file: FILE, changed: FILE, change: Change::NoLength }] }
            }
            Reads::Metal => &metal::CONTROLS,
        }
    }
}

/// A validator.
pub trait Tool: Send + Sync {
    /// Its name on the command line and in tables.
    fn name(&self) -> &str;

    /// How to get it.
    fn remedy(&self) -> String;

    /// Its version, as far as it reports one.
    fn version(&self) -> Result<String, Trouble>;

    /// Whether it reads files of this name.
    fn reads(&self, name: &str) -> bool;

    /// What it has to judge rightly before its verdicts count.
    fn controls(&self) -> &'static [Control];

    /// Checks a file. Where it also executes the shader: the greatest error of the probes, in tolerances.
    fn check(&self, file: &Path) -> Result<Option<f64>, Fault>;
}

/// Runs the tools over every file below `folder`, in parallel.
///
/// Tools that give no verdict are skipped and reported. One of them in `required` is an error, and so is an unknown name.
pub fn validate(folder: &Path, tools: &[Box<dyn Tool>], required: &[String]) -> Result<Report> {
    let names: Vec<&str> = tools.iter().map(|tool| tool.name()).collect();
    if let Some(unknown) = required.iter().find(|name| !names.contains(&name.as_str())) {
        return Err(Error::new(unknown, "is not a known validator")
            .remedy(format_args!("one of {}", names.join(", "))));
    }
    let files = all_files(folder)?;
    let readers: Vec<Vec<usize>> = files
        .iter()
        .map(|file| (0..tools.len()).filter(|&i| tools[i].reads(&name(file))).collect())
        .collect();
    let needed = |i: usize| {
        readers.iter().any(|of| of.contains(&i)) || required.iter().any(|name| name == names[i])
    };
    let states = states(tools, &needed)?;
    for (tool, state) in tools.iter().zip(&states) {
        if let Err(trouble) = state
            && required.iter().any(|name| name == tool.name())
        {
            let cause = format!("is required, but {trouble}");
            return Err(Error::new(tool.name(), cause).remedy(tool.remedy()));
        }
    }

    let silent: Vec<OnceLock<Trouble>> = tools.iter().map(|_| OnceLock::new()).collect();
    let mut jobs: Vec<(usize, &PathBuf)> = Vec::new();
    let mut unread = BTreeSet::new();
    for (file, readers) in files.iter().zip(&readers) {
        let before = jobs.len();
        jobs.extend(readers.iter().filter(|&&i| states[i].is_ok()).map(|&i| (i, file)));
        if jobs.len() == before && is_shader(&name(file)) {
            let named: Vec<&str> = readers.iter().map(|&i| names[i]).collect();
            let reason = match &named[..] {
                [] => "no tool reads it".to_owned(),
                _ => format!("needs one of these tools: {}", named.join(", ")),
            };
            unread.insert(Unread { file: relative(file, folder), reason });
        }
    }
    jobs.sort();
    let verdicts: Vec<(usize, &PathBuf, Verdict)> = jobs
        .par_iter()
        .map(|&(i, file)| (i, file, verdict(&*tools[i], file, &silent[i])))
        .collect();

    let mut failures = Vec::new();
    for (i, file, verdict) in &verdicts {
        let file = relative(file, folder);
        match verdict {
            Verdict::Rejected(message) => failures.push(Failure {
                file,
                tool: names[*i].to_owned(),
                message: message.clone(),
            }),
            Verdict::Skipped => {
                let reason = format!("{} is not answering", names[*i]);
                unread.insert(Unread { file, reason });
            }
            Verdict::Accepted(_) => {}
        }
    }
    let rows = states.into_iter().zip(silent).enumerate().map(|(i, (state, silent))| {
        let of: Vec<&Verdict> = verdicts.iter().filter(|(j, ..)| *j == i).map(|v| &v.2).collect();
        let count = |is: fn(&Verdict) -> bool| of.iter().filter(|verdict| is(verdict)).count();
        let errors: Vec<f64> = of.iter().filter_map(|verdict| verdict.error()).collect();
        ToolReport {
            name: names[i].to_owned(),
            version: state.as_ref().ok().cloned(),
            trouble: state.err().or(silent.into_inner()),
            files: count(|verdict| !matches!(verdict, Verdict::Skipped)),
            rejected: count(|verdict| matches!(verdict, Verdict::Rejected(_))),
            skipped: count(|verdict| matches!(verdict, Verdict::Skipped)),
            executed: errors.iter().copied().reduce(f64::max).map(|worst| (errors.len(), worst)),
        }
    });
    Ok(Report { tools: rows.collect(), failures, unread: unread.into_iter().collect() })
}

/// The version of each tool, or why it gives no verdict. The controls are judged by the needed tools only.
fn states(
    tools: &[Box<dyn Tool>],
    needed: &(impl Fn(usize) -> bool + Sync),
) -> Result<Vec<Result<String, Trouble>>> {
    let package = if (0..tools.len()).any(needed) { Some(control::package()?) } else { None };
    let state = |i: usize| {
        let tool = &*tools[i];
        let version = tool.version();
        match (&version, &package) {
            (Ok(_), Some(package)) if needed(i) => {
                Ok(control::believed(tool, package)?.and(version))
            }
            _ => Ok(version),
        }
    };
    (0..tools.len()).into_par_iter().map(state).collect()
}

/// What a tool said of a file.
enum Verdict {
    Accepted(Option<f64>),
    Rejected(String),
    /// It did not answer on this file, or on an earlier one.
    Skipped,
}

impl Verdict {
    fn error(&self) -> Option<f64> {
        if let Verdict::Accepted(error) = self { *error } else { None }
    }
}

fn verdict(tool: &dyn Tool, file: &Path, silent: &OnceLock<Trouble>) -> Verdict {
    if silent.get().is_some() {
        return Verdict::Skipped;
    }
    match tool.check(file) {
        Ok(error) => Verdict::Accepted(error),
        Err(fault @ Fault::TimedOut(_)) => {
            silent.get_or_init(|| Trouble::NotAnswering(format!("{}: {fault}", file.display())));
            Verdict::Skipped
        }
        Err(fault) => Verdict::Rejected(fault.to_string()),
    }
}
