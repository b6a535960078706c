//! The validators: naga in this process, and command-line tools.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::process::{Fault, GLSLANG, accepted, hlsl_options};

use super::{
    Control, Dxc, HlslSpirv, MetalCpu, Reads, Reflection, Tool, Trouble,
    hlsl::entries,
    shell::{self, Input},
    trouble,
};

/// All validators, installed or not. Each run of one may take as long as `time_limit`.
pub fn tools(time_limit: Duration) -> Vec<Box<dyn Tool>> {
    let external = |name, remedy, reads, options| -> Box<dyn Tool> {
        Box::new(External::new(name, remedy, reads, options).time_limit(time_limit))
    };
    vec![
        Box::new(Naga),
        // Vulkan's rules are stricter than SPIR-V's own
        external("spirv-val", "apt-get install spirv-tools", Reads::Spirv, |_| {
            vec![words(&["--target-env", "vulkan1.0"])]
        }),
        external(GLSLANG, "apt-get install glslang-tools", Reads::GlslHlsl, |name| {
            if name.ends_with(".hlsl") {
                // glslangValidator reads HLSL only if it writes SPIR-V
                let nowhere = if cfg!(windows) { "NUL" } else { "/dev/null" };
                return entries(name)
                    .into_iter()
                    .map(|(entry, stage)| hlsl_options(&entry, stage, nowhere))
                    .collect();
            }
            vec![words(&["-S", if name.contains(".vert") { "vert" } else { "frag" }])]
        }),
        Box::new(HlslSpirv::new(time_limit)),
        Box::new(Dxc::new(time_limit)),
        external("spirv-cross", "apt-get install spirv-cross", Reads::Spirv, |_| {
            vec![words(&["--version", "450"]), words(&["--version", "300", "--es"])]
        }),
        Box::new(Reflection::new(time_limit)),
        // without a format, tint would guess one from the name of an output file, but there is no output file
        external("tint", "put Dawn's program tint on the PATH", Reads::Wgsl, |_| {
            vec![words(&["--format", "wgsl"])]
        }),
        Box::new(MetalCpu::new(time_limit)),
    ]
}

/// naga in this process, which reads WGSL again.
pub struct Naga;

impl Tool for Naga {
    fn name(&self) -> &str {
        "naga"
    }

    fn remedy(&self) -> String {
        "it is part of this program".to_owned()
    }

    fn version(&self) -> Result<String, Trouble> {
        Ok("in process".to_owned())
    }

    fn reads(&self, name: &str) -> bool {
        Reads::Wgsl.name(name)
    }

    fn controls(&self) -> &'static [Control] {
        Reads::Wgsl.controls()
    }

    fn check(&self, file: &Path) -> Result<Option<f64>, Fault> {
        for Input { file, .. } in shell::inputs(file)?.files {
            let text = fs::read_to_string(file).map_err(|error| error.to_string())?;
            let module =
                naga::front::wgsl::parse_str(&text).map_err(|e| e.emit_to_string(&text))?;
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
            validator.validate(&module).map_err(|error| error.emit_to_string(&text))?;
        }
        Ok(None)
    }
}

/// A command-line validator. It gets options and the file, and its exit code is the verdict.
pub struct External {
    name: &'static str,
    remedy: &'static str,
    program: Result<PathBuf, Trouble>,
    reads: Reads,
    /// Options of each run for a file of this name.
    options: fn(&str) -> Vec<Vec<String>>,
    time_limit: Duration,
}

impl External {
    /// Looks for a tool on the PATH.
    pub fn new(
        name: &'static str,
        remedy: &'static str,
        reads: Reads,
        options: fn(&str) -> Vec<Vec<String>>,
    ) -> External {
        let (program, time_limit) = (trouble::program(name), super::TIME_LIMIT);
        External { name, remedy, program, reads, options, time_limit }
    }

    /// Sets the maximum time of a run.
    #[must_use]
    pub fn time_limit(self, time_limit: Duration) -> External {
        External { time_limit, ..self }
    }
}

impl Tool for External {
    fn name(&self) -> &str {
        self.name
    }

    fn remedy(&self) -> String {
        self.remedy.to_owned()
    }

    fn version(&self) -> Result<String, Trouble> {
        let mut command = Command::new(self.program.clone()?);
        // spirv-cross has --revision; tint reports no version
        let question = if self.name == "spirv-cross" { "--revision" } else { "--version" };
        trouble::version(command.arg(question), self.time_limit)
    }

    fn reads(&self, name: &str) -> bool {
        self.reads.name(name)
    }

    fn controls(&self) -> &'static [Control] {
        self.reads.controls()
    }

    fn check(&self, file: &Path) -> Result<Option<f64>, Fault> {
        let program = self.program.as_ref().map_err(ToString::to_string)?;
        for Input { name, file } in shell::inputs(file)?.files {
            for options in (self.options)(&name) {
                accepted(Command::new(program).args(&options).arg(&file), self.time_limit)?;
            }
        }
        Ok(None)
    }
}

fn words(options: &[&str]) -> Vec<String> {
    options.iter().map(|option| (*option).to_owned()).collect()
}
