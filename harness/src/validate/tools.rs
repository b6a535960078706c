//! The validators: naga in this process, and command-line tools.

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
        // Vulkan's rules are stricter than SPIR-V's own
        Box::new(External::new("spirv-val", Some("spirv-tools"), Reads::Spirv, |_| {
            vec![words(&["--target-env", "vulkan1.0"])]
        })),
        Box::new(External::new(GLSLANG, Some(GLSLANG_PACKAGE), Reads::GlslHlsl, |name| {
            if name.ends_with(".hlsl") {
                // glslangValidator reads HLSL only if it writes SPIR-V
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
        // without a format, tint would guess one from the name of an output file, but there is no output file
        Box::new(External::new("tint", None, Reads::Wgsl, |_| vec![words(&["--format", "wgsl"])])),
    ]
}

/// naga in this process, which reads WGSL again.
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

/// A command-line validator. It gets options and the file, and its exit code is the verdict.
pub struct External {
    name: &'static str,
    package: Option<&'static str>,
    program: Option<PathBuf>,
    reads: Reads,
    /// Options of each run for a file of this name.
    options: fn(&str) -> Vec<Vec<String>>,
    time_limit: Duration,
}

impl External {
    /// Looks for a tool on the PATH.
    pub fn new(
        name: &'static str,
        package: Option<&'static str>,
        reads: Reads,
        options: fn(&str) -> Vec<Vec<String>>,
    ) -> External {
        External { name, package, program: on_path(name), reads, options, time_limit: TIME_LIMIT }
    }

    /// Sets the maximum time for one file.
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
        // spirv-cross has --revision; tint reports no version
        let question = if self.name == "spirv-cross" { "--revision" } else { "--version" };
        let answer = run(command.arg(question), self.time_limit).ok();
        let version = answer.filter(|(status, _)| status.success()).and_then(|(_, text)| {
            let line = text.lines().map(str::trim).find(|line| !line.is_empty())?;
            Some(line.to_owned())
        });
        Some(version.unwrap_or_else(|| "unknown version".to_owned()))
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

/// The way from HLSL to Vulkan: glslangValidator compiles HLSL to SPIR-V, which spirv-val checks.
pub struct HlslSpirv {
    programs: Option<(PathBuf, PathBuf)>,
}

impl HlslSpirv {
    /// Looks for both programs on the PATH.
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

/// Entry points of an HLSL file: those of every whole shader, or the one of a shell.
fn hlsl_entries(name: &str) -> Vec<(String, Stage)> {
    if name.starts_with(shell::NAME) {
        return vec![("main".to_owned(), Stage::Fragment)];
    }
    Contract::standard(true).entry_points
}

fn words(options: &[&str]) -> Vec<String> {
    options.iter().map(|option| (*option).to_owned()).collect()
}
