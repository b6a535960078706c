//! Folders for browsers. The next run removes folders that killed processes left behind.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::Duration;

use diffraction_shaders::disk::remove_tree;
use diffraction_shaders::error::Result;
use tempfile::TempDir;

use super::failure::failure;

const PREFIX: &str = "diffraction-browser-";

/// The file that is locked as long as the process that made the folder lives.
const LOCK: &str = "lock";

/// Folders younger than this may not be locked yet.
const YOUNG: Duration = Duration::from_secs(60);

/// A temporary folder for a browser.
#[derive(Debug)]
pub(super) struct UserFolder {
    folder: TempDir,
    _lock: File,
}

impl UserFolder {
    /// Makes a folder, and removes those whose process is gone.
    pub(super) fn new() -> Result<UserFolder> {
        abandoned(&std::env::temp_dir()).iter().for_each(|folder| {
            // another process may do the same
            let _ = remove_tree(folder);
        });
        let made = tempfile::Builder::new().prefix(PREFIX).tempdir().and_then(|folder| {
            let lock = File::create(folder.path().join(LOCK))?;
            lock.lock()?;
            Ok(UserFolder { folder, _lock: lock })
        });
        made.map_err(|e| failure("its profile folder cannot be created").source(e))
    }

    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Removes the folder after its browser ended.
    pub(super) fn remove(&self) {
        // ending processes may still write into it
        for _ in 0..20 {
            if fs::remove_dir_all(self.path()).is_ok() {
                break;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

/// The folders in `place` whose process is gone.
fn abandoned(place: &Path) -> Vec<PathBuf> {
    let ours = |path: &PathBuf| {
        path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(PREFIX))
    };
    let gone = |path: &PathBuf| {
        let Ok(lock) = File::open(path.join(LOCK)) else { return false };
        let age = lock.metadata().and_then(|data| data.modified()).ok();
        let old = age.and_then(|at| at.elapsed().ok()).is_some_and(|age| age > YOUNG);
        old && !matches!(lock.try_lock(), Err(TryLockError::WouldBlock | TryLockError::Error(_)))
    };
    let entries = fs::read_dir(place).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).filter(ours).filter(gone).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_old_folders_that_nobody_holds_are_abandoned() {
        let place = tempfile::tempdir().expect("a folder");
        let make = |name: &str, is_old: bool| {
            let folder = place.path().join(name);
            fs::create_dir(&folder).expect("a folder");
            let lock = File::create(folder.join(LOCK)).expect("a file");
            if is_old {
                lock.set_modified(std::time::SystemTime::UNIX_EPOCH).expect("a time");
            }
            lock
        };
        let held = make("diffraction-browser-held", true);
        held.lock().expect("nobody else holds it");
        drop(make("diffraction-browser-left", true));
        drop(make("diffraction-browser-young", false));
        drop(make("another-program", true));
        fs::create_dir(place.path().join("diffraction-browser-bare")).expect("a folder");
        assert_eq!(abandoned(place.path()), [place.path().join("diffraction-browser-left")]);
        drop(held);
        assert_eq!(abandoned(place.path()).len(), 2);
    }
}
