//! Files that commands write: whole or not at all; and the folder of what can be made again.

use std::path::{Path, PathBuf};

use anyhow::Result;
use etcetera::BaseStrategy;

/// Writes a file completely or not at all ([`diffraction_shaders::disk::write_whole`]).
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    Ok(diffraction_shaders::disk::write_whole(path, bytes)?)
}

/// Our folder in the user's cache folder; without a home, in the folder of temporary files.
pub fn caches() -> PathBuf {
    let caches = etcetera::choose_base_strategy().map(|folders| folders.cache_dir());
    caches.unwrap_or_else(|_| std::env::temp_dir()).join("diffraction-shaders")
}
