//! Metal texts on the processor: a C++ compiler compiles them with a small `metal_stdlib` of ours and runs their probes.
//!
//! This is not Apple's compiler, which runs on Apple's machines only: it accepts C++ that Metal does not have. But what it
//! accepts it also executes: entry points, tables and tolerances as a consumer of the package finds them in its manifest.

mod block;
mod frame;
mod job;
mod main_text;
mod text;

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

use diffraction_cli::interrupt::TemporaryFolder;

use crate::process::{Fault, accepted};

use super::{Change, Control, Reads, Tool, Trouble, trouble};

use job::Job;

/// The compiler. Clang has no `-fsingle-precision-constant`.
const PROGRAM: &str = "g++";
/// Files that the compiler finds in the folder of headers.
const HEADERS: [(&str, &str); 3] = [
    ("metal_stdlib", include_str!("metal/metal_stdlib.h")),
    ("simd/simd.h", ""),
    ("run.h", include_str!("metal/run.h")),
];
/// Constants are floats, as in Metal; and nothing is contracted, so that all processors agree.
const OPTIONS: [&str; 6] = [
    "-std=c++17",
    "-O1",
    "-fsingle-precision-constant",
    "-ffp-contract=off",
    // attributes of Metal, such as [[buffer(0)]]
    "-Wno-attributes",
    "-I",
];

const FILE: &str = "diffraction.metal";
/// A call of what nobody defines; a colour with a wrong sign; a flipped bitangent.
pub(super) const CONTROLS: [Control; 3] = [
    Control::text(FILE, "metal::float3 tristimulus(", "metal::float3 tristimulvs("),
    Control::text(FILE, "3.2406, -1.5372", "3.2406, 1.5372"),
    Control {
        file: FILE,
        changed: FILE,
        change: Change::Text("? -1.0 : 1.0) * metal::cross(", "? 1.0 : -1.0) * metal::cross("),
    },
];

/// Compiles and runs Metal texts.
pub struct MetalCpu {
    program: Result<PathBuf, Trouble>,
    time_limit: Duration,
}

impl MetalCpu {
    /// Looks for the compiler on the PATH.
    #[must_use]
    pub fn new(time_limit: Duration) -> MetalCpu {
        MetalCpu { program: trouble::program(PROGRAM), time_limit }
    }
}

impl Tool for MetalCpu {
    fn name(&self) -> &str {
        "metal-cpu"
    }

    fn remedy(&self) -> String {
        "apt-get install g++".to_owned()
    }

    fn version(&self) -> Result<String, Trouble> {
        let mut command = Command::new(self.program.clone()?);
        let version = trouble::version(command.arg("--version"), self.time_limit)?;
        Ok(format!("{version}; not Apple's compiler"))
    }

    fn reads(&self, name: &str) -> bool {
        Reads::Metal.name(name)
    }

    fn controls(&self) -> &'static [Control] {
        &CONTROLS
    }

    /// A text without a manifest beside it is compiled, and not run.
    fn check(&self, file: &Path) -> Result<Option<f64>, Fault> {
        let program = self.program.as_ref().map_err(ToString::to_string)?;
        let text = fs::read_to_string(file).map_err(|error| error.to_string())?;
        let text = text::for_cpp(&text)?;
        let folder = TemporaryFolder::new().map_err(|error| error.to_string())?;
        let folder = folder.path();
        let write = |name: &str, text: &str| {
            fs::write(folder.join(name), text).map_err(|error| format!("{name}: {error}"))
        };
        fs::create_dir(folder.join("simd")).map_err(|error| error.to_string())?;
        for (name, text) in HEADERS {
            write(name, text)?;
        }
        write("text.h", &text)?;
        let job = match file.with_file_name("manifest.json") {
            manifest if manifest.is_file() => Some(Job::read(file, &text, folder)?),
            _ => None,
        };
        write("main.cpp", job.as_ref().map_or("#include \"text.h\"\n", |job| job.main.as_str()))?;
        let mut compile = Command::new(program);
        compile.args(OPTIONS).arg(folder);
        match &job {
            Some(_) => compile.arg("-o").arg(folder.join("run")),
            None => compile.arg("-fsyntax-only"),
        };
        let compiled = accepted(compile.arg(folder.join("main.cpp")), self.time_limit);
        compiled.map_err(|fault| plain(fault, folder, file))?;
        let Some(job) = job else { return Ok(None) };
        write("job", &job.data)?;
        let mut run = Command::new(folder.join("run"));
        let said = accepted(run.arg(folder.join("job")), self.time_limit)?;
        Ok(Some(job.worst(&said)?))
    }
}

/// The compiler's message without the folder of this run and without the command line.
fn plain(fault: Fault, folder: &Path, file: &Path) -> Fault {
    let Fault::Refused(text) = fault else { return fault };
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let text = text.split_once('\n').map_or(text.as_str(), |(_, said)| said);
    let text = text.replace(&format!("{}/", folder.display()), "").replace("text.h", &name);
    Fault::Refused(format!("{PROGRAM} with our metal_stdlib:\n{text}"))
}
