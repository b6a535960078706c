//! Tests whether `generate` would write again what it wrote last time.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use diffraction_shaders::diagnostic::Diagnostics;
use diffraction_shaders::disk::remove_tree;
use diffraction_shaders::package::Stamp;
use diffraction_shaders::package::compile::Compiler;
use diffraction_shaders::plan::Plan;

/// The cache of another build of the program is removed if nothing was added to it for this time.
const KEPT: Duration = Duration::from_secs(7 * 24 * 3600);

/// Number of digits of a build's hash that name its cache.
const NAME: usize = 12;

/// Hash of the running program. Numbers of another build must not be taken for its own.
pub(crate) fn program() -> Option<String> {
    let bytes = fs::read(std::env::current_exe().ok()?).ok()?;
    Some(diffraction_shaders::hash::sha256(&bytes))
}

/// The folder for this program's finished tables and stamps, inside the cache folder of all programs. Both may be deleted
/// at any time. Removes those of other builds that were not used for a while.
pub(crate) fn cache(caches: &Path, program: &str) -> PathBuf {
    let own = caches.join(program.get(..NAME).unwrap_or(program));
    for entry in fs::read_dir(caches).into_iter().flatten().flatten() {
        // beside them stand what `--setup` installs, and whatever else somebody put there
        let name = entry.file_name();
        let is_hash =
            |name: &str| name.len() == NAME && name.bytes().all(|b| b.is_ascii_hexdigit());
        let is_cache =
            name.to_str().is_some_and(is_hash) && entry.file_type().is_ok_and(|kind| kind.is_dir());
        let age = entry.metadata().and_then(|found| found.modified()).map(|time| time.elapsed());
        if is_cache && entry.path() != own && matches!(age, Ok(Ok(age)) if age > KEPT) {
            let _ = remove_tree(&entry.path());
        }
    }
    own
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

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use super::*;

    #[test]
    fn only_old_caches_of_other_builds_go() {
        let caches = tempfile::tempdir().expect("a folder");
        let old = ["0123456789ab", "ba9876543210", "tools", "notes-of-mine"];
        for name in old.iter().chain(&["aaaaaaaaaaaa"]) {
            fs::create_dir(caches.path().join(name)).expect("a folder");
            fs::write(caches.path().join(name).join("file"), "").expect("writes");
        }
        for name in old {
            let folder = fs::File::open(caches.path().join(name)).expect("opens");
            folder.set_modified(SystemTime::UNIX_EPOCH).expect("dates");
        }
        let own = cache(caches.path(), "ba9876543210ffff");
        assert_eq!(own, caches.path().join("ba9876543210"));
        let is_there = |name: &str| caches.path().join(name).join("file").exists();
        assert!(!is_there(old[0]) && is_there("aaaaaaaaaaaa"));
        assert!(old[1..].iter().all(|name| is_there(name)));
    }
}
