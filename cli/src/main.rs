//! `diffraction`: the compiler's commands in any folder.

use std::process::ExitCode;

use diffraction_cli::{Program, files, harness};

fn main() -> ExitCode {
    let (name, cache) = ("diffraction", files::caches);
    diffraction_cli::main(&Program { name, cache, harness: harness::installed, own: None })
}
