//! Finished tables and probes in a folder, by their identity.
//!
//! The cache is only a saving: what cannot be read or written is computed, and then stays in memory.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::error::Result;
use crate::package::Content;

/// End of the name of a file that is being written.
const PARTIAL: &str = "partial";
/// Age of such a file whose writer is gone.
const STALE: Duration = Duration::from_secs(3600);

/// A folder, or none.
#[derive(Clone, Copy)]
pub(super) struct Cache<'a>(pub(super) Option<&'a Path>);

impl Cache<'_> {
    /// Bytes of that length, from the cache, or made and put there: a file of the cache where there is one.
    pub(super) fn content(
        self,
        id: &str,
        length: usize,
        make: impl FnOnce() -> Result<Vec<u8>>,
    ) -> Result<Content> {
        let Some(file) = self.file(id) else { return Ok(Content::Bytes(make()?)) };
        if fs::metadata(&file).is_ok_and(|found| found.len() == length as u64) {
            return Ok(Content::Stored(file));
        }
        let bytes = make()?;
        Ok(if store(&file, &bytes) { Content::Stored(file) } else { Content::Bytes(bytes) })
    }

    /// So many numbers, from the cache, or made and put there.
    pub(super) fn numbers(
        self,
        id: &str,
        count: usize,
        make: impl FnOnce() -> Result<Vec<f64>>,
    ) -> Result<Vec<f64>> {
        let file = self.file(id);
        if let Some(bytes) = file.as_ref().and_then(|file| fs::read(file).ok())
            && bytes.len() == 8 * count
        {
            return Ok(bytes
                .as_chunks()
                .0
                .iter()
                .map(|&eight| f64::from_le_bytes(eight))
                .collect());
        }
        let numbers = make()?;
        if let Some(file) = file {
            let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
            store(&file, &bytes);
        }
        Ok(numbers)
    }

    /// Removes what killed runs left unfinished, an hour old or more: nothing takes so long to write.
    pub(super) fn sweep(self) {
        let Some(entries) = self.0.and_then(|folder| fs::read_dir(folder).ok()) else { return };
        for path in entries.flatten().map(|entry| entry.path()) {
            let is_partial = path.extension().is_some_and(|e| e == PARTIAL);
            let age = fs::metadata(&path).and_then(|m| m.modified()).map(|at| at.elapsed());
            if is_partial && matches!(age, Ok(Ok(age)) if age >= STALE) {
                let _ = fs::remove_file(&path);
            }
        }
    }

    fn file(self, id: &str) -> Option<PathBuf> {
        self.0.map(|folder| folder.join(format!("{id}.bin")))
    }
}

/// Writes a whole file or none; whether it did.
fn store(file: &Path, bytes: &[u8]) -> bool {
    let partial = file.with_extension(format!("{}.{PARTIAL}", std::process::id()));
    let stored = file
        .parent()
        .map_or(Ok(()), fs::create_dir_all)
        .and_then(|()| fs::write(&partial, bytes))
        .and_then(|()| fs::rename(&partial, file));
    if stored.is_err() {
        let _ = fs::remove_file(&partial);
    }
    stored.is_ok()
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::time::SystemTime;

    use super::*;

    #[test]
    fn what_killed_runs_left_goes_and_the_rest_stays() {
        let folder = tempfile::tempdir().expect("folder");
        let names = ["old.1.partial", "new.2.partial", "old.bin"];
        for name in names {
            let file = File::create(folder.path().join(name)).expect("creates");
            if name.starts_with("old") {
                file.set_modified(SystemTime::UNIX_EPOCH).expect("dates");
            }
        }
        Cache(Some(folder.path())).sweep();
        assert_eq!(names.map(|name| folder.path().join(name).exists()), [false, true, true]);
    }
}
