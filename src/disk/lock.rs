//! One process at a time writes to a folder.
//!
//! The lock is on the folder itself, so it leaves no file behind, and the system releases it when
//! the process ends, however it ends. An absent folder is made first, and removed again if nothing comes into it. Where
//! folders cannot be locked (some network file systems; Windows), a file beside the folder is.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

use super::owner;

/// What a lock is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Others may read at the same time, and none writes.
    Read,
    /// Nobody else.
    Write,
}

/// A locked folder. It is released when this is dropped.
#[derive(Debug)]
pub struct FolderLock {
    root: PathBuf,
    /// The folder; after an exchange, the new one too. Nothing for an absent folder that is only read.
    held: Vec<File>,
    /// The file beside it, where that is locked instead.
    beside: Option<PathBuf>,
    /// Folders that were made for it, the innermost first.
    created: Vec<PathBuf>,
}

impl FolderLock {
    /// Locks a folder. To write, it is made if it is absent. While another process has it, `waiting` is called once, with a
    /// line to show, and then this waits. What is there afterwards may be another folder than before.
    pub fn take(folder: &Path, access: Access, waiting: &dyn Fn(&str)) -> Result<FolderLock> {
        let error = |cause: &str| Error::new(format!("output {}", folder.display()), cause);
        let (mut has_waited, mut attempts) = (false, 0);
        let mut created = Vec::new();
        let mut wait = |file: &File| -> io::Result<()> {
            match (try_lock(file, access), has_waited) {
                (Err(TryLockError::WouldBlock), false) => {
                    let what = if access == Access::Read { "is written" } else { "is in use" };
                    waiting(&format!(
                        "output {}: {what} by another run; waiting for it",
                        folder.display()
                    ));
                    has_waited = true;
                    lock(file, access)
                }
                (Err(TryLockError::WouldBlock), true) => lock(file, access),
                (Err(TryLockError::Error(e)), _) => Err(e),
                (Ok(()), _) => Ok(()),
            }
        };
        // what is locked may have been removed or exchanged meanwhile
        loop {
            let root = resolve(folder)?;
            match fs::metadata(&root) {
                Ok(found) if found.is_dir() => {}
                Ok(_) => {
                    return Err(error("is not a folder").remedy("name another folder with --out"));
                }
                Err(e) if e.kind() == io::ErrorKind::NotFound => {
                    if access == Access::Read {
                        return Ok(FolderLock { root, held: vec![], beside: None, created });
                    }
                    attempts += 1;
                    match create(&root, &mut created) {
                        // another run may remove what this one makes folders in; some places take no folder, ever
                        Err(e) if e.kind() != io::ErrorKind::NotFound || attempts > 50 => {
                            return Err(unmakable(&error, existing(&root), e));
                        }
                        _ => continue,
                    }
                }
                Err(e) => {
                    return Err(error("cannot be read").source(e).remedy("check its permissions"));
                }
            }
            let (file, beside) = match File::open(&root) {
                Ok(file) => match wait(&file) {
                    Ok(()) => (file, None),
                    Err(_) => beside(&root, access, &mut wait).map_err(|e| {
                        let cause = "cannot be locked, and neither can a file beside it";
                        error(cause).source(e).remedy("name a folder on another disk with --out")
                    })?,
                },
                Err(e) if e.kind() == io::ErrorKind::NotFound => continue,
                Err(_) if !cfg!(unix) => beside(&root, access, &mut wait)
                    .map_err(|e| error("cannot be locked").source(e))?,
                Err(e) => {
                    return Err(error("cannot be read").source(e).remedy("check its permissions"));
                }
            };
            let place = beside.as_deref().unwrap_or(&root);
            if same(&file, place) && fs::metadata(&root).is_ok() {
                return Ok(FolderLock { root, held: vec![file], beside, created });
            }
        }
    }

    /// The folder's path without links.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The folders that were made for it, the innermost first.
    pub fn created(&self) -> &[PathBuf] {
        &self.created
    }

    /// Also holds a folder that this process has locked and is about to put in the place of this one.
    pub(crate) fn also(&mut self, file: File) {
        self.held.push(file);
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // only empty folders can be removed like this
        self.created.iter().for_each(|folder| drop(fs::remove_dir(folder)));
        if let Some(beside) = &self.beside {
            let _ = fs::remove_file(beside);
        }
    }
}

/// Locks a new folder of this process's own, to be handed to [`FolderLock::also`].
pub(crate) fn lock_new(folder: &Path) -> Option<File> {
    let file = File::open(folder).ok()?;
    file.try_lock().ok()?;
    Some(file)
}

fn try_lock(file: &File, access: Access) -> Result<(), TryLockError> {
    match access {
        Access::Read => file.try_lock_shared(),
        Access::Write => file.try_lock(),
    }
}

fn lock(file: &File, access: Access) -> io::Result<()> {
    loop {
        let done = match access {
            Access::Read => file.lock_shared(),
            Access::Write => file.lock(),
        };
        match done {
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            done => return done,
        }
    }
}

/// Whether an open file or folder is the one that a path leads to.
#[cfg(unix)]
fn same(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |found: fs::Metadata| (found.dev(), found.ino());
    file.metadata().map(id).ok() == fs::metadata(path).map(id).ok()
}

#[cfg(not(unix))]
fn same(_file: &File, path: &Path) -> bool {
    path.exists()
}

/// Locks the file `.NAME.lock` beside a folder.
fn beside(
    root: &Path,
    access: Access,
    wait: &mut dyn FnMut(&File) -> io::Result<()>,
) -> io::Result<(File, Option<PathBuf>)> {
    let mut name = std::ffi::OsString::from(".");
    name.push(root.file_name().unwrap_or_default());
    name.push(".lock");
    let path = root.with_file_name(name);
    let mut options = OpenOptions::new();
    let opened = options.write(true).create(true).truncate(false).open(&path);
    match opened {
        Ok(file) => wait(&file).map(|()| (file, Some(path))),
        // a folder that cannot be written to is not being written
        Err(_) if access == Access::Read => Ok((File::open(root)?, None)),
        Err(e) => Err(e),
    }
}

/// Makes a folder and those above it, and notes which were made.
fn create(root: &Path, created: &mut Vec<PathBuf>) -> io::Result<()> {
    let absent = |folder: &&Path| fs::symlink_metadata(folder).is_err();
    let missing: Vec<&Path> =
        root.ancestors().take_while(|folder| *folder != Path::new("") && absent(folder)).collect();
    for folder in missing.into_iter().rev() {
        match fs::create_dir(folder) {
            Ok(()) => {
                created.retain(|known| known != folder);
                created.insert(0, folder.to_owned());
            }
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists && folder.is_dir() => {}
            Err(e) => {
                created.drain(..).for_each(|folder| drop(fs::remove_dir(folder)));
                return Err(e);
            }
        }
    }
    Ok(())
}

/// The innermost folder on the way to a path that exists.
fn existing(root: &Path) -> Option<&Path> {
    root.ancestors().skip(1).find(|folder| fs::metadata(folder).is_ok())
}

fn unmakable(error: &dyn Fn(&str) -> Error, holder: Option<&Path>, e: io::Error) -> Error {
    let Some(holder) = holder else { return error("cannot be created").source(e) };
    let shown = match holder {
        holder if holder == Path::new("") => Path::new("."),
        holder => holder,
    };
    if !holder.is_dir() {
        let cause = format!("cannot be created, since {} is not a folder", shown.display());
        return error(&cause).remedy("name another folder with --out");
    }
    let whose = owner(holder).map(|owner| format!(" (user {owner}'s)")).unwrap_or_default();
    let remedy = format!(
        "check the permissions and the free space of the folder {}{whose}, or name another folder with --out",
        shown.display()
    );
    error("cannot be created").source(e).remedy(remedy)
}

/// The path of a folder without symbolic links, whether it exists or not.
pub fn resolve(folder: &Path) -> Result<PathBuf> {
    let error = |cause: &str| Error::new(format!("output {}", folder.display()), cause);
    if let Ok(root) = fs::canonicalize(folder) {
        return Ok(root);
    }
    if fs::symlink_metadata(folder).is_ok() {
        let cause = "is a symbolic link to a folder that does not exist";
        return Err(error(cause).remedy("remove the link, or name another folder with --out"));
    }
    let Some(name) = folder.file_name() else {
        return Err(error("is not the path of a folder").remedy("name a folder with --out"));
    };
    let parent = match folder.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let parent = fs::canonicalize(parent).unwrap_or_else(|_| parent.to_owned());
    Ok(parent.join(name))
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;
    use std::time::Duration;

    use super::*;

    fn quiet(_: &str) {}

    fn write(folder: &Path) -> FolderLock {
        FolderLock::take(folder, Access::Write, &quiet).expect("locks")
    }

    #[test]
    fn an_absent_folder_is_made_and_goes_again_if_it_stays_empty() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = place.path().join("a/b/c");
        let lock = write(&folder);
        assert_eq!(lock.created().len(), 3);
        assert!(folder.is_dir());
        drop(lock);
        assert!(!place.path().join("a").exists());
        let lock = write(&folder);
        fs::write(folder.join("file"), "").expect("writes");
        drop(lock);
        assert!(folder.join("file").exists());
        let absent = place.path().join("absent");
        let reading = FolderLock::take(&absent, Access::Read, &quiet).expect("nothing to lock");
        assert!(!absent.exists() && reading.created().is_empty());
    }

    #[test]
    fn the_second_waits_with_a_word_and_finds_the_folder_that_is_there_then() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = place.path().join("out");
        let mut first = write(&folder);
        let (said, heard) = mpsc::channel();
        let second = std::thread::spawn({
            let folder = folder.clone();
            move || {
                let tell = |text: &str| drop(said.send(text.to_owned()));
                let lock = FolderLock::take(&folder, Access::Write, &tell).expect("locks");
                fs::read_to_string(lock.root().join("text")).expect("the new folder")
            }
        });
        let text = heard.recv_timeout(Duration::from_secs(60)).expect("it says so");
        assert!(text.contains("in use by another run; waiting"), "{text}");
        // another folder comes into its place
        let new = place.path().join("new");
        fs::create_dir(&new).expect("a folder");
        fs::write(new.join("text"), "new").expect("writes");
        if let Some(file) = lock_new(&new) {
            first.also(file);
        }
        fs::remove_dir(&folder).and_then(|()| fs::rename(&new, &folder)).expect("renames");
        assert!(!second.is_finished());
        drop(first);
        assert_eq!(second.join().expect("ends"), "new");
    }

    #[test]
    fn readers_read_together_and_no_writer_with_them() {
        let place = tempfile::tempdir().expect("a folder");
        let read = || FolderLock::take(place.path(), Access::Read, &quiet).expect("locks");
        let two = (read(), read());
        let other = File::open(place.path()).expect("opens");
        assert!(matches!(other.try_lock(), Err(TryLockError::WouldBlock)));
        drop(two);
        other.try_lock().expect("nobody reads");
    }

    #[test]
    fn a_file_beside_the_folder_does_where_folders_cannot_be_locked() {
        let place = tempfile::tempdir().expect("a folder");
        let root = place.path().join("out");
        fs::create_dir(&root).expect("a folder");
        let mut wait = |file: &File| file.try_lock().map_err(io::Error::from);
        let (file, path) = beside(&root, Access::Write, &mut wait).expect("locks");
        assert_eq!(path.as_deref(), Some(place.path().join(".out.lock").as_path()));
        assert!(beside(&root, Access::Write, &mut wait).is_err(), "it is taken");
        drop(FolderLock { root, held: vec![file], beside: path, created: vec![] });
        assert_eq!(fs::read_dir(place.path()).expect("reads").count(), 1, "and goes again");
    }
}
