//! HLSL: its entry points, and its way to Vulkan.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

use diffraction_cli::interrupt::TemporaryFolder;
use diffraction_shaders::shader::module::{Contract, Stage};
use diffraction_shaders::variant::FUNCTIONS;

use crate::process::{Fault, GLSLANG, GLSLANG_PACKAGE, accepted, hlsl_to_spirv};

use super::{
    Control, Reads, Tool, Trouble,
    shell::{self, Input},
    trouble,
};

/// The way from HLSL to Vulkan: glslangValidator compiles HLSL to SPIR-V, which spirv-val checks.
pub struct HlslSpirv {
    programs: Result<(PathBuf, PathBuf), Trouble>,
    time_limit: Duration,
}

impl HlslSpirv {
    /// Looks for both programs on the PATH.
    #[must_use]
    pub fn new(time_limit: Duration) -> HlslSpirv {
        let validator = || trouble::program("spirv-val");
        let programs = trouble::program(GLSLANG).and_then(|found| Ok((found, validator()?)));
        HlslSpirv { programs, time_limit }
    }
}

impl Tool for HlslSpirv {
    fn name(&self) -> &str {
        "hlsl-spirv-val"
    }

    fn remedy(&self) -> String {
        format!("apt-get install {GLSLANG_PACKAGE} spirv-tools")
    }

    fn version(&self) -> Result<String, Trouble> {
        self.programs.clone().map(|_| "both of the above".to_owned())
    }

    fn reads(&self, name: &str) -> bool {
        Reads::Hlsl.name(name)
    }

    fn controls(&self) -> &'static [Control] {
        Reads::Hlsl.controls()
    }

    fn check(&self, file: &Path) -> Result<Option<f64>, Fault> {
        let (compiler, validator) = self.programs.as_ref().map_err(ToString::to_string)?;
        let folder = TemporaryFolder::new().map_err(|error| error.to_string())?;
        let spirv = folder.path().join("shader.spv");
        for input in shell::inputs(file)?.files {
            for (entry, stage) in all_entries(&input)? {
                hlsl_to_spirv(compiler, &input.file, (&entry, stage), &spirv, self.time_limit)?;
                let mut validate = Command::new(validator);
                let validate = validate.args(["--target-env", "vulkan1.0"]).arg(&spirv);
                accepted(validate, self.time_limit)?;
            }
        }
        Ok(None)
    }
}

/// Entry points that an HLSL file must have: those of every whole shader, or the one of a shell.
pub(super) fn entries(name: &str) -> Vec<(String, Stage)> {
    if name.starts_with(shell::NAME) {
        return vec![("main".to_owned(), Stage::Fragment)];
    }
    Contract::standard(true).entry_points
}

/// The same, and those for meshes where the text has them.
pub(super) fn all_entries(input: &Input) -> Result<Vec<(String, Stage)>, String> {
    let text = fs::read_to_string(&input.file).map_err(|error| error.to_string())?;
    let mut all = entries(&input.name);
    for point in Contract::package(&FUNCTIONS, true).entry_points {
        if !all.contains(&point) && text.contains(&format!(" {}(", point.0)) {
            all.push(point);
        }
    }
    Ok(all)
}
