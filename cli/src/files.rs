//! Files that commands write: whole or not at all.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

/// Writes a file beside its place and moves it there, so that an interrupted write leaves the old one.
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
