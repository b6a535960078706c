//! Files that commands write: whole or not at all; and the folder of what can be made again.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use etcetera::BaseStrategy;

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

/// Our folder in the user's cache folder; without a home, in the folder of temporary files.
pub fn caches() -> PathBuf {
    let caches = etcetera::choose_base_strategy().map(|folders| folders.cache_dir());
    caches.unwrap_or_else(|_| std::env::temp_dir()).join("diffraction-shaders")
}
