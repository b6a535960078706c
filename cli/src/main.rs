//! `diffraction`: the compiler's commands in any folder.

use std::path::PathBuf;
use std::process::ExitCode;

use diffraction_cli::{Program, harness};
use etcetera::BaseStrategy;

fn main() -> ExitCode {
    let program = Program { name: "diffraction", cache, harness: harness::installed, own: None };
    diffraction_cli::main(&program)
}

/// The user's folder of caches; without a home, that of temporary files.
fn cache() -> PathBuf {
    let caches = etcetera::choose_base_strategy().map(|folders| folders.cache_dir());
    caches.unwrap_or_else(|_| std::env::temp_dir()).join("diffraction-shaders")
}
