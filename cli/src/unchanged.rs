//! Tests whether `generate` would write again what it wrote last time.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use diffraction_shaders::diagnostic::Diagnostics;
use diffraction_shaders::package::Stamp;
use diffraction_shaders::package::compile::Compiler;
use diffraction_shaders::plan::Plan;

use crate::interrupt::TemporaryFolder;

/// The cache of another build of the program is removed if nothing was added to it for this time.
const KEPT: Duration = Duration::from_secs(7 * 24 * 3600);

/// Hash of the running program. Numbers of another build must not be taken for its own.
pub(crate) fn program() -> Option<String> {
    let bytes = fs::read(std::env::current_exe().ok()?).ok()?;
    Some(diffraction_shaders::hash::sha256(&bytes))
}

/// The folder for this program's finished tables and stamps, inside the cache folder of all programs. Both may be deleted
/// at any time.
pub(crate) fn cache(caches: &Path, program: &str) -> PathBuf {
    let own = caches.join(program.get(..12).unwrap_or(program));
    for entry in fs::read_dir(caches).into_iter().flatten().flatten() {
        let age = entry.metadata().and_then(|found| found.modified()).map(|time| time.elapsed());
        if entry.path() != own && matches!(age, Ok(Ok(age)) if age > KEPT) {
            let _ = fs::remove_dir_all(entry.path()).or_else(|_| fs::remove_file(entry.path()));
        }
    }
    own
}

/// A folder for the tables of one run without the cache.
pub(crate) fn spill(caches: &Path) -> std::io::Result<TemporaryFolder> {
    let folder = caches.join("spilled");
    fs::create_dir_all(&folder)?;
    tempfile::tempdir_in(folder).map(TemporaryFolder::of)
}

/// The stamp of an output folder, and the hash of inputs that it must hold.
pub(crate) struct Expected {
    file: PathBuf,
    pub(crate) inputs: String,
}

impl Expected {
    /// `None` if the folder or the cache has no path.
    pub(crate) fn new(
        compiler: &Compiler<'_>,
        plan: &Plan,
        cache: &Path,
        out: &Path,
        program: &str,
    ) -> Result<Option<Expected>, Diagnostics> {
        let hash = |text: String| diffraction_shaders::hash::sha256(text.as_bytes());
        let inputs = compiler.input_hash()?;
        let Ok(out) = std::path::absolute(out) else { return Ok(None) };
        let name = format!("stamp-{}.json", hash(out.display().to_string()));
        let inputs = hash(format!("{program} {} {inputs}", plan.text_hash));
        Ok(Some(Expected { file: cache.join(name), inputs }))
    }

    /// The stamp, if its inputs match and the output folder still holds all files that it lists.
    pub(crate) fn unchanged(&self, out: &Path) -> Option<Stamp> {
        Stamp::read(&self.file).filter(|stamp| stamp.inputs == self.inputs && stamp.holds(out))
    }

    /// Writes a stamp. If that fails, the next run is only slower.
    pub(crate) fn keep(&self, stamp: &Stamp) {
        let _ = stamp.write(&self.file);
    }
}
