//! Folders for browsers. The next run removes folders that killed processes left behind.

use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use diffraction_cli::interrupt::{BeforeExit, before_exit};
use diffraction_shaders::error::Result;
use diffraction_shaders::input::read_file;
use tempfile::TempDir;

use super::failure::failure;

const PREFIX: &str = "diffraction-browser-";

/// The file that is locked as long as the process that made the folder lives.
const LOCK: &str = "lock";

/// Content of that file. A folder without it is not ours, whatever its name.
const MARK: &[u8] = b"profile of a browser, made by diffraction-shaders\n";

/// Folders younger than this may not be locked yet.
const YOUNG: Duration = Duration::from_secs(60);

/// A temporary folder for a browser.
#[derive(Debug)]
pub(super) struct UserFolder {
    folder: TempDir,
    _lock: File,
    _removed: BeforeExit,
}

impl UserFolder {
    /// Makes a folder, and removes those whose process is gone.
    pub(super) fn new() -> Result<UserFolder> {
        sweep(&std::env::temp_dir());
        let made = tempfile::Builder::new().prefix(PREFIX).tempdir().and_then(|folder| {
            let path = folder.path().to_owned();
            let removed = before_exit(move || {
                let _ = clear(&path);
            });
            let mut lock = File::create_new(folder.path().join(LOCK))?;
            lock.lock()?;
            lock.write_all(MARK)?;
            Ok(UserFolder { folder, _lock: lock, _removed: removed })
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
            if clear(self.path()).is_ok() {
                break;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

/// Removes a folder of ours. The mark goes last: a process that is killed meanwhile leaves a folder that the next run knows.
fn clear(folder: &Path) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)?.flatten().filter(|entry| entry.file_name() != LOCK) {
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        let path = entry.path();
        if is_folder { fs::remove_dir_all(path)? } else { fs::remove_file(path)? }
    }
    fs::remove_dir_all(folder)
}

/// Removes the folders in `place` whose process is gone, and empty ones whose process ended before it could mark them.
fn sweep(place: &Path) {
    // another process may do the same
    for folder in named(place) {
        if is_abandoned(&folder) {
            let _ = clear(&folder);
        } else if is_old(&folder) {
            // fails unless it is empty
            let _ = fs::remove_dir(folder);
        }
    }
}

/// The folders in `place` that have a name of ours. Links are left out: they lead to what somebody else made.
fn named(place: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(place).into_iter().flatten().flatten();
    let ours = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(PREFIX));
    ours.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()))
        .map(|entry| entry.path())
        .collect()
}

/// Whether a folder has our mark and its process is gone.
fn is_abandoned(folder: &Path) -> bool {
    let path = folder.join(LOCK);
    // neither a link nor a pipe, which might never be opened
    let is_file = fs::symlink_metadata(&path).is_ok_and(|data| data.is_file());
    if !is_file
        || !is_old(&path)
        || read_file(&path, MARK.len() as u64).ok().as_deref() != Some(MARK)
    {
        return false;
    }
    let Ok(lock) = File::open(path) else { return false };
    !matches!(lock.try_lock(), Err(TryLockError::WouldBlock | TryLockError::Error(_)))
}

/// Whether something was last changed a while ago.
fn is_old(path: &Path) -> bool {
    let changed = fs::symlink_metadata(path).and_then(|data| data.modified());
    changed.is_ok_and(|at| at.elapsed().is_ok_and(|age| age > YOUNG))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_marked_folders_that_nobody_holds_are_removed() {
        let place = tempfile::tempdir().expect("a folder");
        let long_ago = std::time::SystemTime::UNIX_EPOCH;
        let path = |name: &str| place.path().join(name);
        let make = |name: &str, mark: &[u8], is_old: bool| {
            fs::create_dir(path(name)).expect("a folder");
            let mut lock = File::create(path(name).join(LOCK)).expect("a file");
            lock.write_all(mark).expect("writes");
            if is_old {
                lock.set_modified(long_ago).expect("a time");
            }
            lock
        };
        let aged = |name: &str| {
            let folder = File::open(path(name)).expect("opens");
            folder.set_modified(long_ago).expect("a time");
        };
        let held = make("diffraction-browser-held", MARK, true);
        held.lock().expect("nobody else holds it");
        drop(make("diffraction-browser-left", MARK, true));
        drop(make("diffraction-browser-young", MARK, false));
        drop(make("diffraction-browser-foreign", b"somebody's notes", true));
        drop(make("another-program", MARK, true));
        for (name, is_aged) in [("bare", true), ("fresh", false)] {
            let name = format!("diffraction-browser-{name}");
            fs::create_dir(path(&name)).expect("a folder");
            if is_aged {
                aged(&name);
            }
        }
        let mut stay = vec!["held", "young", "foreign", "fresh"];
        #[cfg(unix)]
        {
            use std::os::unix::fs::symlink;
            // planted: a link to a marked folder, a lock that is a link, a lock that is a pipe
            drop(make("victim", MARK, true));
            fs::write(path("victim/file"), "precious").expect("writes");
            symlink(path("victim"), path("diffraction-browser-link")).expect("links");
            fs::create_dir(path("diffraction-browser-through")).expect("a folder");
            let lock = path("diffraction-browser-through").join(LOCK);
            symlink(path("victim").join(LOCK), lock).expect("links");
            fs::create_dir(path("diffraction-browser-pipe")).expect("a folder");
            let pipe = path("diffraction-browser-pipe").join(LOCK);
            let made = std::process::Command::new("mkfifo").arg(pipe).status().expect("runs");
            assert!(made.success());
            aged("diffraction-browser-pipe");
            stay.extend(["link", "through", "pipe"]);
        }
        sweep(place.path());
        for gone in ["left", "bare"] {
            assert!(!path(&format!("diffraction-browser-{gone}")).exists(), "{gone}");
        }
        for name in stay {
            assert!(path(&format!("diffraction-browser-{name}")).exists(), "{name}");
        }
        assert!(path("another-program").exists());
        #[cfg(unix)]
        assert!(path("victim/file").exists());
        drop(held);
        sweep(place.path());
        assert!(!path("diffraction-browser-held").exists());
    }
}
