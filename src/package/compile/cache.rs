//! A folder of finished tables and probes, named by their identity.
//!
//! The cache only saves time: a file that cannot be read or written is computed and kept in memory. Each file has the
//! hash of its content beside it, and a file whose content has another hash is computed again. So neither a flipped bit
//! nor an edited cache can get into a package.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::error::Result;
use crate::hash::{sha256, sha256_of};
use crate::package::Content;

/// Extension of files that are being written.
const PARTIAL: &str = "partial";
/// Age at which such a file counts as abandoned.
const STALE: Duration = Duration::from_secs(3600);

/// The folder of the cache; `None` turns the cache off.
#[derive(Clone, Copy)]
pub(super) struct Cache<'a>(pub(super) Option<&'a Path>);

impl Cache<'_> {
    /// Content of that length: read from the cache, or computed and stored there. Refers to a file of the cache if
    /// there is one.
    pub(super) fn content(
        self,
        id: &str,
        length: usize,
        make: impl FnOnce() -> Result<Vec<u8>>,
    ) -> Result<Content> {
        let Some(file) = self.file(id) else { return Ok(Content::Bytes(make()?)) };
        if is_whole(&file, length) {
            return Ok(Content::Stored(file));
        }
        let bytes = make()?;
        Ok(if store(&file, &bytes) { Content::Stored(file) } else { Content::Bytes(bytes) })
    }

    /// `count` numbers: read from the cache, or computed and stored there.
    pub(super) fn numbers(
        self,
        id: &str,
        count: usize,
        make: impl FnOnce() -> Result<Vec<f64>>,
    ) -> Result<Vec<f64>> {
        let file = self.file(id);
        if let Some(bytes) = file.as_ref().and_then(|file| fs::read(file).ok())
            && bytes.len() == 8 * count
            && stored_hash(file.as_deref()) == Some(sha256(&bytes))
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

    /// Removes unfinished files of killed runs. They are at least an hour old; no file takes that long to write.
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

/// Whether a file has that length and still has the content it was written with.
fn is_whole(file: &Path, length: usize) -> bool {
    fs::metadata(file).is_ok_and(|found| found.len() == length as u64)
        && stored_hash(Some(file))
            .is_some_and(|hash| File::open(file).and_then(sha256_of).is_ok_and(|own| own == hash))
}

/// The hash stored beside a file.
fn stored_hash(file: Option<&Path>) -> Option<String> {
    fs::read_to_string(hash_file(file?)).ok()
}

fn hash_file(file: &Path) -> PathBuf {
    file.with_extension("sha256")
}

/// Writes a file and its hash, each completely or not at all. Returns whether both were written. The hash is written
/// first, because a hash without its file does no harm.
fn store(file: &Path, bytes: &[u8]) -> bool {
    let folder = file.parent().map_or(Ok(()), fs::create_dir_all);
    folder.is_ok()
        && write_whole(&hash_file(file), sha256(bytes).as_bytes())
        && write_whole(file, bytes)
}

/// Writes a file completely or not at all. Returns whether it was written.
fn write_whole(file: &Path, bytes: &[u8]) -> bool {
    let mut name = file.as_os_str().to_owned();
    name.push(format!(".{}.{PARTIAL}", std::process::id()));
    let partial = PathBuf::from(name);
    let written = fs::write(&partial, bytes).and_then(|()| fs::rename(&partial, file));
    if written.is_err() {
        let _ = fs::remove_file(&partial);
    }
    written.is_ok()
}

#[cfg(test)]
mod tests {
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

    /// A flipped bit, a wrong hash, a missing hash, a wrong length: each time the file is computed again.
    #[test]
    fn damaged_files_are_made_anew() {
        let folder = tempfile::tempdir().expect("folder");
        let cache = Cache(Some(folder.path()));
        let bytes = || Ok(vec![7; 5000]);
        let of = |content: Content| content.read().expect("readable").into_owned();
        let never = || panic!("it is whole");
        let numbers = || Ok(vec![1.5, -2.0]);
        let (table, hash) = (folder.path().join("table.bin"), folder.path().join("table.sha256"));
        let damages: [&dyn Fn(); 4] = [
            &|| {
                let mut damaged = fs::read(&table).expect("readable");
                damaged[4321] ^= 4;
                fs::write(&table, damaged).expect("writes");
            },
            &|| fs::write(&hash, sha256(b"other")).expect("writes"),
            &|| fs::remove_file(&hash).expect("removes"),
            &|| fs::write(&table, [7; 4999]).expect("writes"),
        ];
        for damage in damages {
            cache.content("table", 5000, bytes).expect("made");
            assert_eq!(of(cache.content("table", 5000, never).expect("whole")), [7; 5000]);
            damage();
            assert_eq!(of(cache.content("table", 5000, bytes).expect("made anew")), [7; 5000]);
        }
        cache.numbers("probes", 2, numbers).expect("made");
        assert_eq!(cache.numbers("probes", 2, || panic!("whole")).expect("whole"), [1.5, -2.0]);
        let file = folder.path().join("probes.bin");
        let mut damaged = fs::read(&file).expect("readable");
        damaged[6] ^= 1;
        fs::write(&file, damaged).expect("writes");
        assert_eq!(cache.numbers("probes", 2, numbers).expect("made anew"), [1.5, -2.0]);
    }
}
