//! DXC, Microsoft's compiler of HLSL: every entry point must compile to DXIL, and to SPIR-V that spirv-val accepts.
//!
//! It runs as the program `dxc`, or as its library alone, which a Python package contains and `validate --setup` installs.

use std::{
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

use diffraction_shaders::shader::module::Stage;

use crate::process::{Fault, accepted, on_path, tools_folder};

use super::{Control, Reads, Tool, Trouble, hlsl::all_entries, shell, trouble};

/// The library below [`tools_folder`].
pub const LIBRARY: &str = "dxc/libdxcompiler.so";
/// The command line of `dxc` for the library alone.
const SCRIPT: &str = include_str!("../../python/dxc.py");

/// The program, or Python with the library.
#[derive(Clone)]
enum Compiler {
    Program(PathBuf),
    Library { python: PathBuf, library: PathBuf },
}

/// Compiles HLSL by DXC.
pub struct Dxc {
    compiler: Result<Compiler, Trouble>,
    /// Checks the SPIR-V, where it is installed.
    validator: Option<PathBuf>,
    time_limit: Duration,
}

impl Dxc {
    /// Looks for the program on the PATH, then for the library in [`tools_folder`].
    #[must_use]
    pub fn new(time_limit: Duration) -> Dxc {
        let library = tools_folder().join(LIBRARY);
        let compiler = match trouble::program("dxc") {
            Ok(program) => Ok(Compiler::Program(program)),
            Err(_) if library.is_file() => {
                trouble::program("python3").map(|python| Compiler::Library { python, library })
            }
            Err(trouble) => Err(trouble),
        };
        Dxc { compiler, validator: on_path("spirv-val"), time_limit }
    }

    fn command(&self) -> Result<Command, Trouble> {
        Ok(match self.compiler.clone()? {
            Compiler::Program(program) => Command::new(program),
            Compiler::Library { python, library } => {
                let mut command = Command::new(python);
                command.args(["-I", "-c", SCRIPT]).arg(library);
                command
            }
        })
    }

    /// Runs the compiler on a file. Messages name the options, not the script.
    fn compile(&self, options: &[&str], file: &Path) -> Result<(), Fault> {
        let mut command = self.command().map_err(|trouble| trouble.to_string())?;
        match accepted(command.args(options).arg(file), self.time_limit) {
            Err(Fault::Refused(text)) => {
                let said = text.split_once('\n').map_or(text.as_str(), |(_, said)| said);
                let options: Vec<&str> =
                    options.iter().copied().take_while(|word| *word != "-Fo").collect();
                Err(Fault::Refused(format!("dxc {}:\n{said}", options.join(" "))))
            }
            other => other.map(|_| ()),
        }
    }
}

impl Tool for Dxc {
    fn name(&self) -> &str {
        "dxc"
    }

    fn remedy(&self) -> String {
        format!(
            "put the program dxc on the PATH, or run {} validate --setup",
            diffraction_cli::program::name()
        )
    }

    fn version(&self) -> Result<String, Trouble> {
        trouble::version(self.command()?.arg("--version"), self.time_limit)
    }

    fn reads(&self, name: &str) -> bool {
        Reads::Hlsl.name(name)
    }

    fn controls(&self) -> &'static [Control] {
        Reads::Hlsl.controls()
    }

    fn check(&self, file: &Path) -> Result<Option<f64>, Fault> {
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let spirv = folder.path().join("shader.spv");
        let output = spirv.to_string_lossy();
        for input in shell::inputs(file)?.files {
            for (entry, stage) in all_entries(&input)? {
                let profile = match stage {
                    Stage::Vertex => "vs_6_0",
                    Stage::Fragment => "ps_6_0",
                };
                let options = ["-T", profile, "-E", &entry];
                self.compile(&options, &input.file)?;
                if let Some(validator) = &self.validator {
                    let more = [&options[..], &["-spirv", "-Fo", &output]].concat();
                    self.compile(&more, &input.file)?;
                    accepted(Command::new(validator).arg(&spirv), self.time_limit)?;
                }
            }
        }
        Ok(None)
    }
}
