//! Whether a run of `generate` would write what the last one wrote.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use diffraction_shaders::diagnostic::Diagnostics;
use diffraction_shaders::package::Stamp;
use diffraction_shaders::package::compile::Compiler;
use diffraction_shaders::plan::Plan;

/// Caches of other programs are removed when nothing was added for so long.
const KEPT: Duration = Duration::from_secs(7 * 24 * 3600);

/// Hash of this very program, so that no other's numbers are taken for its own.
pub(crate) fn program() -> Option<String> {
    let bytes = fs::read(std::env::current_exe().ok()?).ok()?;
    Some(diffraction_shaders::hash::sha256(&bytes))
}

/// The folder of this program's finished tables, stamps among them, in that of all programs, which is safe to delete.
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

/// A folder for the tables of one run that neither reads nor writes the cache.
pub(crate) fn spill(caches: &Path) -> std::io::Result<tempfile::TempDir> {
    let folder = caches.join("spilled");
    fs::create_dir_all(&folder)?;
    tempfile::tempdir_in(folder)
}

/// The stamp of an output folder, and what it has to say of the inputs.
pub(crate) struct Expected {
    file: PathBuf,
    pub(crate) inputs: String,
}

impl Expected {
    /// `None` where it cannot be told.
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

    /// The stamp, if the output folder still holds all that it tells.
    pub(crate) fn unchanged(&self, out: &Path) -> Option<Stamp> {
        Stamp::read(&self.file).filter(|stamp| stamp.inputs == self.inputs && stamp.holds(out))
    }

    /// Keeps a stamp; without one the next run is only slower.
    pub(crate) fn keep(&self, stamp: &Stamp) {
        let _ = stamp.write(&self.file);
    }
}
