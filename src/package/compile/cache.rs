//! A folder of finished tables and probes, named by their identity.
//!
//! The cache only saves time: a file that cannot be read or written is computed, and kept for this run in a file without a
//! name, or in memory. Each file has the hash of its content beside it, and a file whose content has another hash is
//! computed again. So neither a flipped bit nor an edited cache can get into a package.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;

use crate::disk::{Spill, clear, open_regular, read_regular, write_whole};
use crate::error::{Error, Result};
use crate::hash::{sha256, sha256_of};
use crate::package::Content;

/// Age at which what killed runs left half-written counts as abandoned.
const STALE: Duration = Duration::from_secs(3600);

/// Size up to which a table without a cache stays in memory, bytes.
const SMALL: usize = 1 << 20;

/// What is kept of finished tables, and where.
#[derive(Debug, Default)]
pub(super) struct Cache<'a> {
    /// The folder of the cache; `None` turns the cache off.
    folder: Option<&'a Path>,
    /// Space for this run alone.
    spill: Spill,
    /// Why something could not be stored in the folder.
    trouble: OnceLock<Error>,
}

impl<'a> Cache<'a> {
    pub(super) fn new(folder: Option<&'a Path>) -> Cache<'a> {
        Cache { folder, ..Cache::default() }
    }

    /// Why something could not be stored in the folder, if that was so.
    pub(super) fn trouble(&self) -> Option<&Error> {
        self.trouble.get()
    }

    /// Content of that length: read from the cache, or computed and stored there. Large content is not in memory.
    pub(super) fn content(
        &self,
        id: &str,
        length: usize,
        make: impl FnOnce() -> Result<Vec<u8>>,
    ) -> Result<Content> {
        let file = self.file(id);
        if let Some(file) = &file
            && let Some(sha256) = whole_hash(file, length)
        {
            return Ok(Content::Stored { file: file.clone(), sha256 });
        }
        let bytes = make()?;
        if let Some(file) = file
            && self.store(&file, &bytes)
        {
            return Ok(Content::Stored { file, sha256: sha256(&bytes) });
        }
        if bytes.len() <= SMALL {
            return Ok(Content::Bytes(bytes));
        }
        // without room for temporary files, memory is left
        Ok(self.spill.keep(&bytes).map_or_else(|_| Content::Bytes(bytes), Content::Spilled))
    }

    /// `count` numbers: read from the cache, or computed and stored there.
    pub(super) fn numbers(
        &self,
        id: &str,
        count: usize,
        make: impl FnOnce() -> Result<Vec<f64>>,
    ) -> Result<Vec<f64>> {
        let file = self.file(id);
        if let Some(bytes) = file.as_ref().and_then(|file| read_regular(file).ok())
            && bytes.len() == 8 * count
            && file.as_ref().and_then(|file| stored_hash(file)) == Some(sha256(&bytes))
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
            self.store(&file, &bytes);
        }
        Ok(numbers)
    }

    /// Removes unfinished files of killed runs. They are at least an hour old; no file takes that long to write.
    pub(super) fn sweep(&self) {
        let Some(entries) = self.folder.and_then(|folder| fs::read_dir(folder).ok()) else {
            return;
        };
        for path in entries.flatten().map(|entry| entry.path()) {
            let is_partial =
                path.file_name().is_some_and(|name| is_partial(&name.to_string_lossy()));
            let found = fs::symlink_metadata(&path);
            let age = found.and_then(|m| m.modified()).map(|at| at.elapsed());
            if is_partial && matches!(age, Ok(Ok(age)) if age >= STALE) {
                let _ = fs::remove_file(&path);
            }
        }
    }

    fn file(&self, id: &str) -> Option<PathBuf> {
        self.folder.map(|folder| folder.join(format!("{id}.bin")))
    }

    /// Writes a file and its hash, each completely or not at all. Returns whether both were written. The hash is written
    /// first, because a hash without its file does no harm.
    fn store(&self, file: &Path, bytes: &[u8]) -> bool {
        let folder = file.parent().map_or(Ok(()), fs::create_dir_all);
        let folder = folder.map_err(|e| {
            let folder = file.parent().unwrap_or(file);
            Error::new(folder.display(), "cannot be created").source(e)
        });
        let stored = folder.and_then(|()| {
            let (beside, line) = (hash_file(file), hash_line(file, &sha256(bytes)));
            for (path, bytes) in [(beside.as_path(), line.as_bytes()), (file, bytes)] {
                clear(path);
                write_whole(path, bytes)?;
            }
            Ok(())
        });
        match stored {
            Ok(()) => true,
            Err(error) => {
                let _ = self.trouble.set(error);
                false
            }
        }
    }
}

/// Whether a name is that of a file of the cache before it is complete: of this version or of earlier ones.
fn is_partial(name: &str) -> bool {
    name.starts_with(".diffraction-tmp-") || name.ends_with(".partial")
}

/// The hash of a file, if it has that length and still has the content that it was written with.
fn whole_hash(file: &Path, length: usize) -> Option<String> {
    let expected = stored_hash(file)?;
    let open = open_regular(file).ok()?;
    let is_long = open.metadata().ok()?.len() == length as u64;
    (is_long && sha256_of(open).ok()? == expected).then_some(expected)
}

/// The hash stored beside a file. It is stored with the file's name, so that it is of no other file.
fn stored_hash(file: &Path) -> Option<String> {
    let line = String::from_utf8(read_regular(&hash_file(file)).ok()?).ok()?;
    let hash = line.get(..64)?;
    (line == hash_line(file, hash)).then(|| hash.to_owned())
}

/// A hash as `sha256sum` writes it and checks it.
fn hash_line(file: &Path, hash: &str) -> String {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    format!("{hash}  {name}\n")
}

fn hash_file(file: &Path) -> PathBuf {
    file.with_extension("sha256")
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
            let file = fs::File::create(folder.path().join(name)).expect("creates");
            if name.starts_with("old") {
                file.set_modified(SystemTime::UNIX_EPOCH).expect("dates");
            }
        }
        Cache::new(Some(folder.path())).sweep();
        assert_eq!(names.map(|name| folder.path().join(name).exists()), [false, true, true]);
    }

    /// Whatever happens to the files of an entry: it is computed again, and what it holds then is right.
    #[cfg(unix)]
    #[test]
    fn damaged_files_are_made_anew() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        use std::process::Command;

        use crate::hash::sha256;

        let folder = tempfile::tempdir().expect("folder");
        let cache = Cache::new(Some(folder.path()));
        let at = |name: &str| folder.path().join(name);
        let (table, hash, other) = (at("table.bin"), at("table.sha256"), at("other.bin"));
        let write = |path: &Path, bytes: &[u8]| fs::write(path, bytes).expect("writes");
        let edit = |path: &Path, edit: &dyn Fn(&mut Vec<u8>)| {
            let mut bytes = fs::read(path).expect("readable");
            edit(&mut bytes);
            write(path, &bytes);
        };
        let gone = |path: &Path| fs::remove_file(path).expect("removes");
        let swap = |a: &Path, b: &Path| {
            let between = at("between");
            let moves = [(a, between.as_path()), (b, a), (between.as_path(), b)];
            moves.into_iter().for_each(|(from, to)| fs::rename(from, to).expect("renames"));
        };
        let pipe = |path: &Path| {
            gone(path);
            assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo runs").success());
        };
        let link = |to: &Path, path: &Path| {
            gone(path);
            symlink(to, path).expect("links");
        };
        type Damage<'a> = Box<dyn Fn() + 'a>;
        let damages: Vec<(&str, Damage<'_>)> = vec![
            ("a bit flipped", Box::new(|| edit(&table, &|bytes| bytes[4321] ^= 4))),
            ("its first bit flipped", Box::new(|| edit(&table, &|bytes| bytes[0] ^= 128))),
            ("its last bit flipped", Box::new(|| edit(&table, &|bytes| bytes[4999] ^= 1))),
            ("cut by one byte", Box::new(|| edit(&table, &|bytes| bytes.truncate(4999)))),
            ("cut to half", Box::new(|| edit(&table, &|bytes| bytes.truncate(2500)))),
            ("empty", Box::new(|| write(&table, b""))),
            ("longer by one byte", Box::new(|| edit(&table, &|bytes| bytes.push(7)))),
            ("zeros", Box::new(|| write(&table, &[0; 5000]))),
            ("two bytes swapped", Box::new(|| edit(&table, &|bytes| bytes.swap(0, 1)))),
            ("exchanged with another table", Box::new(|| swap(&table, &other))),
            (
                "exchanged with another table and its hash",
                Box::new(|| {
                    swap(&table, &other);
                    swap(&hash, &at("other.sha256"));
                }),
            ),
            ("a link to another table", Box::new(|| link(&other, &table))),
            ("a link to itself", Box::new(|| link(&table, &table))),
            ("a link that leads nowhere", Box::new(|| link(&at("absent"), &table))),
            ("a pipe", Box::new(|| pipe(&table))),
            (
                "an empty folder",
                Box::new(|| {
                    gone(&table);
                    fs::create_dir(&table).expect("a folder");
                }),
            ),
            ("gone", Box::new(|| gone(&table))),
            (
                "read-only and damaged",
                Box::new(|| {
                    edit(&table, &|bytes| bytes[9] ^= 1);
                    let mode = fs::Permissions::from_mode(0o444);
                    fs::set_permissions(&table, mode).expect("sets");
                }),
            ),
            (
                "of a mode that lets nobody read",
                Box::new(|| {
                    edit(&table, &|bytes| bytes[9] ^= 1);
                    fs::set_permissions(&table, fs::Permissions::from_mode(0o000)).expect("sets");
                }),
            ),
            ("a hash of something else", Box::new(|| write(&hash, sha256(b"other").as_bytes()))),
            ("a hash with no name", Box::new(|| edit(&hash, &|bytes| bytes.truncate(64)))),
            ("a hash in capitals", Box::new(|| edit(&hash, &|b| b[..64].make_ascii_uppercase()))),
            ("a hash that is empty", Box::new(|| write(&hash, b""))),
            ("a hash that is no text", Box::new(|| write(&hash, &[255; 80]))),
            ("a hash that is a pipe", Box::new(|| pipe(&hash))),
            ("no hash", Box::new(|| gone(&hash))),
        ];
        let original = |i: usize| (i * i % 251) as u8;
        let bytes = || Ok((0..5000).map(original).collect());
        let others = || Ok((0..5000).map(|i| !original(i)).collect());
        let of = |content: Content| content.read().expect("readable").into_owned();
        let expected: Vec<u8> = bytes().expect("made");
        for (name, damage) in &damages {
            cache.content("table", 5000, bytes).expect("made");
            cache.content("other", 5000, others).expect("made");
            let kept = cache.content("table", 5000, || panic!("{name}: before, it is whole"));
            assert_eq!(of(kept.expect("whole")), expected);
            damage();
            let mut is_made = false;
            let again = cache.content("table", 5000, || {
                is_made = true;
                bytes()
            });
            assert_eq!(of(again.expect("made anew")), expected, "{name}");
            assert!(is_made, "{name}: was taken for whole");
            let stored = cache.content("table", 5000, || panic!("{name}: is not stored again"));
            assert_eq!(of(stored.expect("whole")), expected, "{name}");
        }
        assert!(cache.trouble().is_none(), "{:?}", cache.trouble());
    }

    #[test]
    fn damaged_numbers_are_made_anew() {
        let folder = tempfile::tempdir().expect("folder");
        let cache = Cache::new(Some(folder.path()));
        let numbers = || Ok(vec![1.5, -2.0]);
        cache.numbers("probes", 2, numbers).expect("made");
        assert_eq!(cache.numbers("probes", 2, || panic!("whole")).expect("whole"), [1.5, -2.0]);
        let file = folder.path().join("probes.bin");
        let mut damaged = fs::read(&file).expect("readable");
        damaged[6] ^= 1;
        fs::write(&file, damaged).expect("writes");
        assert_eq!(cache.numbers("probes", 2, numbers).expect("made anew"), [1.5, -2.0]);
    }

    /// A cache that takes nothing costs time only, and says so.
    #[test]
    fn without_a_place_for_files_the_content_is_the_same() {
        let folder = tempfile::tempdir().expect("folder");
        let file = folder.path().join("file");
        fs::write(&file, "not a folder").expect("writes");
        let within = file.join("cache");
        for place in [None, Some(within.as_path())] {
            let cache = Cache::new(place);
            let content = cache.content("small", 3, || Ok(vec![1, 2, 3])).expect("made");
            assert_eq!(content, Content::Bytes(vec![1, 2, 3]));
            let large: Vec<u8> = (0..SMALL + 3).map(|i| i as u8).collect();
            let content = cache.content("table", large.len(), || Ok(large.clone())).expect("made");
            if cfg!(unix) {
                assert!(matches!(content, Content::Spilled(_)), "not spilled");
            }
            assert!(*content.read().expect("reads") == large);
            assert_eq!(cache.numbers("n", 1, || Ok(vec![0.5])).expect("made"), [0.5]);
            assert_eq!(cache.trouble().is_some(), place.is_some());
        }
        assert_eq!(fs::read(&file).expect("reads"), b"not a folder");
    }
}
