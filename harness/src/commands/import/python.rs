//! Finds a Python that has the library which reads files of instruments.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Result, bail};
use diffraction_cli::program;

use crate::commands::setup::IMPORT;
use crate::process::{accepted, on_path};

/// Names a Python.
const VARIABLE: &str = "DIFFRACTION_PYTHON";
/// Exit code 0 where the library is there. It is not imported, which takes seconds.
const ASK: &str =
    "import importlib.util, sys; sys.exit(importlib.util.find_spec('SurfaceTopography') is None)";
const TIME_LIMIT: Duration = Duration::from_secs(60);

/// The Python that `DIFFRACTION_PYTHON` names, else that of `--setup`, else `python3` if it has the library.
pub(super) fn find() -> Result<PathBuf> {
    if let Some(named) = env::var_os(VARIABLE).filter(|named| !named.is_empty()) {
        let named = PathBuf::from(named);
        if !has_library(&named) {
            bail!("{VARIABLE}={}: is no Python that has SurfaceTopography", named.display());
        }
        return Ok(named);
    }
    let own = IMPORT.folder().join("bin/python");
    let found = [Some(own), on_path("python3")].into_iter().flatten().find(|p| has_library(p));
    match found {
        Some(python) => Ok(python),
        None => bail!(
            "files of instruments are read by the Python library SurfaceTopography, which is not there; install it (500 MB) with\n  \
             {} import --setup\nor name a Python that has it: {VARIABLE}=PATH",
            program::name()
        ),
    }
}

/// A command that runs a script. Python must not take modules from the working folder.
pub(super) fn command(python: &Path, script: &str) -> Command {
    let mut command = Command::new(python);
    command.env("PYTHONSAFEPATH", "1").args(["-B", "-c", script]);
    command
}

fn has_library(python: &Path) -> bool {
    accepted(command(python, ASK).arg("-"), TIME_LIMIT).is_ok()
}
