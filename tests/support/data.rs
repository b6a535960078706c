//! Measured data that is not part of the repository: tests use it where it is, and say so where it is not.

use std::io::Write;
use std::path::{Path, PathBuf};

/// A file of the data folder: that of the environment variable `DIFFRACTION_DATA`, or `../shared/data` beside the
/// repository. `None`, with a line on stderr, where neither has it; a folder that was named and lacks it is a failure.
pub fn find(name: &str) -> Option<PathBuf> {
    let named = std::env::var_os("DIFFRACTION_DATA").map(PathBuf::from);
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    // tests of other crates of the repository look here, too
    let root = own.ancestors().find(|folder| folder.join("Cargo.lock").is_file()).unwrap_or(own);
    let beside = || root.join("../shared/data");
    let path = named.clone().unwrap_or_else(beside).join(name);
    if path.is_file() {
        return Some(path);
    }
    assert!(named.is_none(), "DIFFRACTION_DATA has no {name}");
    // not by a macro: the test runner would hide the line of a test that passes
    let _ = writeln!(
        std::io::stderr(),
        "NOT RUN: {name} is missing; name its folder in DIFFRACTION_DATA"
    );
    None
}
