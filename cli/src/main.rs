//! `diffraction`: the compiler's commands in any folder.

use std::path::PathBuf;
use std::process::ExitCode;

use diffraction_cli::{Program, harness};
use etcetera::BaseStrategy;

fn main() -> ExitCode {
    let program = Program { name: "diffraction", cache, harness: harness::installed, own: None };
    diffraction_cli::main(&program)
}

/// A folder in the user's cache folder; without a home, in the folder of temporary files.
fn cache() -> PathBuf {
    let caches = etcetera::choose_base_strategy().map(|folders| folders.cache_dir());
    caches.unwrap_or_else(|_| std::env::temp_dir()).join("diffraction-shaders")
}
