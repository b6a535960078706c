//! DXC, Microsoft's compiler of HLSL: every entry point must compile to DXIL, and to SPIR-V that spirv-val accepts.
//!
//! It runs as the program `dxc`, or as its library alone, which a Python package contains and `validate --setup` installs.

use std::{
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

use diffraction_cli::interrupt::TemporaryFolder;
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

    /// Runs the compiler once for each list of options with a file; the library for all of them at once.
    fn compile(&self, runs: &[Vec<String>]) -> Result<(), Fault> {
        let command = || self.command().map_err(|trouble| trouble.to_string());
        if matches!(self.compiler, Ok(Compiler::Program(_))) {
            for options in runs {
                accepted(command()?.args(options), self.time_limit)?;
            }
            return Ok(());
        }
        match accepted(command()?.args(runs.join(&",".to_owned())), self.time_limit) {
            // the message names the options; the command line is the whole script
            Err(Fault::Refused(text)) => {
                let said =
                    text.split_once("exit status: 1\n").map_or(text.as_str(), |(_, said)| said);
                Err(Fault::Refused(format!("dxc {said}")))
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
        let folder = TemporaryFolder::new().map_err(|error| error.to_string())?;
        let (mut runs, mut written) = (Vec::new(), Vec::new());
        for input in shell::inputs(file)?.files {
            for (entry, stage) in all_entries(&input)? {
                let profile = match stage {
                    Stage::Vertex => "vs_6_0",
                    Stage::Fragment => "ps_6_0",
                };
                let text = input.file.to_string_lossy().into_owned();
                let run = |more: &[&str]| {
                    let words = [&["-T", profile, "-E", &entry], more, &[&text]].concat();
                    words.into_iter().map(str::to_owned).collect::<Vec<_>>()
                };
                runs.push(run(&[]));
                if self.validator.is_some() {
                    let spirv = folder.path().join(format!("{entry}.spv"));
                    runs.push(run(&["-spirv", "-Fo", &spirv.to_string_lossy()]));
                    written.push(spirv);
                }
            }
            self.compile(&std::mem::take(&mut runs))?;
        }
        for (spirv, validator) in written.iter().zip(self.validator.iter().cycle()) {
            accepted(Command::new(validator).arg(spirv), self.time_limit)?;
        }
        Ok(None)
    }
}
