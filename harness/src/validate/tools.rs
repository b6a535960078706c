//! naga in this process, and the command-line validators.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

use diffraction_shaders::shader::module::{Contract, Stage};
use diffraction_shaders::variant::FUNCTIONS;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::process::{
    GLSLANG, GLSLANG_PACKAGE, accepted, hlsl_options, hlsl_to_spirv, on_path, run,
};

use super::{
    Reads, Reflection, TIME_LIMIT, Tool,
    shell::{self, Input},
};

/// All validators, installed or not.
pub fn tools() -> Vec<Box<dyn Tool>> {
    vec![
        Box::new(Naga),
        // Vulkan's rules are stricter than those of SPIR-V alone
        Box::new(External::new("spirv-val", Some("spirv-tools"), Reads::Spirv, |_| {
            vec![words(&["--target-env", "vulkan1.0"])]
        })),
        Box::new(External::new(GLSLANG, Some(GLSLANG_PACKAGE), Reads::GlslHlsl, |name| {
            if name.ends_with(".hlsl") {
                // reads HLSL only to write SPIR-V
                let nowhere = if cfg!(windows) { "NUL" } else { "/dev/null" };
                return hlsl_entries(name)
                    .into_iter()
                    .map(|(entry, stage)| hlsl_options(&entry, stage, nowhere))
                    .collect();
            }
            vec![words(&["-S", if name.contains(".vert") { "vert" } else { "frag" }])]
        })),
        Box::new(HlslSpirv::new()),
        Box::new(External::new("spirv-cross", Some("spirv-cross"), Reads::Spirv, |_| {
            vec![words(&["--version", "450"]), words(&["--version", "300", "--es"])]
        })),
        Box::new(Reflection::new()),
        // without a format it guesses one from the name of an output file, of which there is none
        Box::new(External::new("tint", None, Reads::Wgsl, |_| vec![words(&["--format", "wgsl"])])),
    ]
}

/// Reads WGSL again in this process.
pub struct Naga;

impl Tool for Naga {
    fn name(&self) -> &str {
        "naga"
    }

    fn package(&self) -> Option<&str> {
        None
    }

    fn version(&self) -> Option<String> {
        Some("in process".to_owned())
    }

    fn reads(&self, name: &str) -> bool {
        Reads::Wgsl.name(name)
    }

    fn check(&self, file: &Path) -> Result<(), String> {
        for Input { file, .. } in shell::inputs(file)?.files {
            let text = fs::read_to_string(file).map_err(|error| error.to_string())?;
            let module =
                naga::front::wgsl::parse_str(&text).map_err(|e| e.emit_to_string(&text))?;
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
            validator.validate(&module).map_err(|error| error.emit_to_string(&text))?;
        }
        Ok(())
    }
}

/// A validator on the command line: it gets options and the file, and says by its exit code what it thinks.
pub struct External {
    name: &'static str,
    package: Option<&'static str>,
    program: Option<PathBuf>,
    reads: Reads,
    /// Options of each run over a file of that name.
    options: fn(&str) -> Vec<Vec<String>>,
    time_limit: Duration,
}

impl External {
    /// A tool that is looked for on the PATH.
    pub fn new(
        name: &'static str,
        package: Option<&'static str>,
        reads: Reads,
        options: fn(&str) -> Vec<Vec<String>>,
    ) -> External {
        External { name, package, program: on_path(name), reads, options, time_limit: TIME_LIMIT }
    }

    /// Gives it less, or more, time for one file.
    #[must_use]
    pub fn time_limit(mut self, limit: Duration) -> External {
        self.time_limit = limit;
        self
    }

    fn command(&self) -> Option<Command> {
        self.program.as_ref().map(Command::new)
    }
}

impl Tool for External {
    fn name(&self) -> &str {
        self.name
    }

    fn package(&self) -> Option<&str> {
        self.package
    }

    fn version(&self) -> Option<String> {
        let mut command = self.command()?;
        // spirv-cross tells its revision, tint nothing at all
        let question = if self.name == "spirv-cross" { "--revision" } else { "--version" };
        let answer = run(command.arg(question), self.time_limit).ok();
        let told = answer.filter(|(status, _)| status.success()).and_then(|(_, text)| {
            let line = text.lines().map(str::trim).find(|line| !line.is_empty())?;
            Some(line.to_owned())
        });
        Some(told.unwrap_or_else(|| "unknown version".to_owned()))
    }

    fn reads(&self, name: &str) -> bool {
        self.reads.name(name)
    }

    fn check(&self, file: &Path) -> Result<(), String> {
        for Input { name, file } in shell::inputs(file)?.files {
            for options in (self.options)(&name) {
                let mut command = self.command().ok_or("not installed")?;
                accepted(command.args(&options).arg(&file), self.time_limit)?;
            }
        }
        Ok(())
    }
}

/// SPIR-V that glslangValidator makes of HLSL, read by spirv-val: the way from HLSL to Vulkan.
pub struct HlslSpirv {
    programs: Option<(PathBuf, PathBuf)>,
}

impl HlslSpirv {
    /// Both programs are looked for on the PATH.
    #[must_use]
    #[expect(clippy::new_without_default, reason = "it looks at the machine")]
    pub fn new() -> HlslSpirv {
        HlslSpirv { programs: on_path(GLSLANG).zip(on_path("spirv-val")) }
    }
}

impl Tool for HlslSpirv {
    fn name(&self) -> &str {
        "hlsl-spirv-val"
    }

    fn package(&self) -> Option<&str> {
        Some("glslang-tools spirv-tools")
    }

    fn version(&self) -> Option<String> {
        self.programs.as_ref().map(|_| "both of the above".to_owned())
    }

    fn reads(&self, name: &str) -> bool {
        Reads::Hlsl.name(name)
    }

    fn check(&self, file: &Path) -> Result<(), String> {
        let (compiler, validator) = self.programs.as_ref().ok_or("not installed")?;
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let spirv = folder.path().join("shader.spv");
        for Input { name, file } in shell::inputs(file)?.files {
            let text = fs::read_to_string(&file).map_err(|error| error.to_string())?;
            let mesh = Contract::package(&FUNCTIONS, true).entry_points.into_iter();
            let known = hlsl_entries(&name);
            let more = mesh
                .filter(|point| !known.contains(point) && text.contains(&format!(" {}(", point.0)));
            for (entry, stage) in known.iter().cloned().chain(more) {
                hlsl_to_spirv(compiler, &file, (&entry, stage), &spirv, TIME_LIMIT)?;
                let mut validate = Command::new(validator);
                accepted(validate.args(["--target-env", "vulkan1.0"]).arg(&spirv), TIME_LIMIT)?;
            }
        }
        Ok(())
    }
}

/// Entry points of a HLSL file: those that every whole shader has, or the one of a shell.
fn hlsl_entries(name: &str) -> Vec<(String, Stage)> {
    if name.starts_with(shell::NAME) {
        return vec![("main".to_owned(), Stage::Fragment)];
    }
    Contract::standard(true).entry_points
}

fn words(options: &[&str]) -> Vec<String> {
    options.iter().map(|option| (*option).to_owned()).collect()
}
