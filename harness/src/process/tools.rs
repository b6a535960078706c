//! The folder of what commands install for themselves.

use std::env;
use std::path::PathBuf;

/// Names another folder.
const VARIABLE: &str = "DIFFRACTION_TOOLS";

/// The folder: the one that the environment variable `DIFFRACTION_TOOLS` names, else one in the user's cache folder.
pub fn tools_folder() -> PathBuf {
    match env::var_os(VARIABLE) {
        Some(folder) if !folder.is_empty() => folder.into(),
        _ => diffraction_cli::files::caches().join("tools"),
    }
}
