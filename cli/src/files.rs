//! Writes files whole or not at all.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

/// Writes a temporary file beside the target and renames it, so that an interrupted write leaves the old file.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    if path.is_dir() {
        bail!("{}: is a folder; name a file", path.display());
    }
    let mut partial = path.as_os_str().to_owned();
    partial.push(format!(".tmp-{}", std::process::id()));
    let written = fs::write(&partial, bytes).and_then(|()| fs::rename(&partial, path));
    if written.is_err() {
        let _ = fs::remove_file(&partial);
    }
    written.with_context(|| format!("{}: cannot be written", path.display()))
}
