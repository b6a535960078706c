//! Writing a package: it is built beside the output and exchanged in one step. So neither readers nor crashes ever see
//! half of it.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::input::read_file;

use super::folder::{self, Folder, sibling};
use super::{Content, Equality, Package, equality};

/// Result of a write.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteReport {
    /// Number of files of the package.
    pub files: usize,
    /// Their total size.
    pub bytes: u64,
    /// Files of the previous package that were removed.
    pub removed: Vec<String>,
    /// Foreign files that were carried over.
    pub carried: Vec<PathBuf>,
    /// The previous output, if it could not be removed completely. The next run tries again.
    pub left_behind: Option<PathBuf>,
}

/// Cancels a write from another thread. The previous output stays complete.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<Mutex<bool>>);

impl Cancel {
    /// A new handle, not cancelled.
    pub fn new() -> Cancel {
        Cancel::default()
    }

    /// Cancels. When it returns, the exchange has either happened or will not happen.
    pub fn cancel(&self) {
        *self.lock() = true;
    }

    /// Whether it was cancelled.
    pub fn is_cancelled(&self) -> bool {
        *self.lock()
    }

    fn lock(&self) -> MutexGuard<'_, bool> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Writes a package to `out`, which must be absent, empty or a package.
///
/// The package is built in `OUT.tmp-PID`, which is then exchanged with `OUT` in one step. Foreign files are carried
/// over. After any error the previous output is unchanged and the temporary folder is removed. Temporary folders of
/// dead processes are removed too.
pub fn write(package: &Package, out: &Path) -> Result<WriteReport> {
    write_unless(package, out, &Cancel::new())
}

/// Like [`write()`], until cancelled.
pub fn write_unless(package: &Package, out: &Path, cancel: &Cancel) -> Result<WriteReport> {
    let error = |cause: &str| Error::new(format!("output {}", out.display()), cause);
    if let Some(parent) = out.parent() {
        fs::create_dir_all(parent).map_err(|e| {
            error("its parent folder cannot be created").source(e).remedy(PERMISSIONS)
        })?;
    }
    let root = folder::resolve(out)?;
    restore_set_aside(&root).map_err(|e| {
        let remedy = "rename the folder OUT.old-PID back to OUT yourself";
        error("the previous output cannot be restored after a crash").source(e).remedy(remedy)
    })?;
    let old = folder::open(out)?;
    remove_stale(&root).map_err(|e| {
        error("a temporary folder of an aborted run cannot be removed")
            .source(e)
            .remedy("remove the folders OUT.tmp-PID beside it yourself")
    })?;
    let temporary = {
        // under the lock: whoever cancels finds the folder, or it is never made
        let cancelled = cancel.lock();
        if *cancelled {
            return Err(interrupted(out));
        }
        Temporary::create(sibling(&root, &format!(".tmp-{}", std::process::id()))?)?
    };
    let mut report = build(package, &temporary.path, cancel)?;
    if let Some(old) = &old {
        report.carried = carry(package, old, &temporary.path)?;
        let gone = |path: &&String| !package.files().contains_key(*path);
        report.removed = old.listed.keys().filter(gone).cloned().collect();
        let permissions = fs::metadata(&root).map(|found| found.permissions());
        permissions
            .and_then(|permissions| fs::set_permissions(&temporary.path, permissions))
            .map_err(|e| {
                error("its permissions cannot be copied to the new output")
                    .source(e)
                    .remedy(PERMISSIONS)
            })?;
    }
    {
        let cancelled = cancel.lock();
        if *cancelled {
            return Err(interrupted(out));
        }
        match &old {
            Some(old) => {
                exchange(&temporary.path, &root)
                    .map_err(|e| error("cannot be replaced").source(e).remedy(PERMISSIONS))?;
                adopt_latecomers(old, &temporary.path, &root, &report.carried);
            }
            None => {
                fs::rename(&temporary.path, &root)
                    .map_err(|e| error("cannot be created").source(e).remedy(PERMISSIONS))?;
            }
        }
        sync_folder(root.parent().unwrap_or(&root));
    }
    // An interrupt handler may be removing it at the same time, so only its absence counts.
    if fs::remove_dir_all(&temporary.path).is_err() && temporary.path.exists() {
        report.left_behind = Some(temporary.path.clone());
    }
    Ok(report)
}

/// `OUT.tmp-PID`, locked while this process lives and removed when dropped.
struct Temporary {
    path: PathBuf,
    _lock: Option<File>,
}

impl Temporary {
    fn create(path: PathBuf) -> Result<Temporary> {
        let error = |e: io::Error| {
            let remedy =
                "check that the folder is writable and that no other run writes to the same output";
            Error::new(path.display(), "cannot be created").source(e).remedy(remedy)
        };
        fs::create_dir(&path).map_err(error)?;
        let lock = lock_folder(&path);
        Ok(Temporary { path, _lock: lock })
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // After the exchange this is the previous output. The caller reports errors.
        let _ = fs::remove_dir_all(&self.path);
    }
}

/// Remedy of errors in the folder that holds the output.
const PERMISSIONS: &str = "check the permissions of the folder that holds it";

fn interrupted(out: &Path) -> Error {
    Error::new(format!("output {}", out.display()), "the run was interrupted; nothing was changed")
}

fn build(package: &Package, into: &Path, cancel: &Cancel) -> Result<WriteReport> {
    let mut report = WriteReport::default();
    let mut folders = BTreeSet::from([into.to_owned()]);
    let fail = |path: &str, e: io::Error| {
        Error::new(format!("generated file {path}"), "cannot be written")
            .source(e)
            .remedy("check permissions and free space")
    };
    for (path, file) in package.files() {
        if cancel.is_cancelled() {
            return Err(interrupted(into));
        }
        let at = into.join(path);
        let parent = at.parent().unwrap_or(into);
        let bytes = fs::create_dir_all(parent).and_then(|()| match &file.content {
            Content::Bytes(bytes) => write_file(&at, bytes),
            Content::Stored(from) | Content::Kept(from) => fs::copy(from, &at),
        });
        report.files += 1;
        report.bytes += bytes.map_err(|e| fail(path, e))?;
        folders.insert(parent.to_owned());
    }
    // Files are synced after all are written: the first sync waits for the disk, and by then most others are on it.
    package.files().par_iter().try_for_each(|(path, _)| {
        if cancel.is_cancelled() {
            return Err(interrupted(into));
        }
        File::open(into.join(path)).and_then(|file| file.sync_all()).map_err(|e| fail(path, e))
    })?;
    folders.iter().for_each(|folder| sync_folder(folder));
    Ok(report)
}

fn write_file(at: &Path, bytes: &[u8]) -> io::Result<u64> {
    let mut file = OpenOptions::new().write(true).create_new(true).open(at)?;
    file.write_all(bytes)?;
    Ok(bytes.len() as u64)
}

/// Errors are ignored: a file system that cannot sync folders still renames them in order.
fn sync_folder(path: &Path) {
    if let Ok(folder) = File::open(path) {
        let _ = folder.sync_all();
    }
}

/// Links or copies the foreign files of the old output into the new one.
fn carry(package: &Package, old: &Folder, into: &Path) -> Result<Vec<PathBuf>> {
    let mut carried = Vec::new();
    for path in old.foreign()? {
        let (from, to) = (old.root.join(&path), into.join(&path));
        let error = |cause: &str| Error::new(format!("foreign file {}", from.display()), cause);
        let conflict = || {
            error("is in the way of a generated file").remedy("move it out of the output folder")
        };
        let is_folder = fs::symlink_metadata(&from).is_ok_and(|found| found.is_dir());
        if fs::symlink_metadata(&to).is_ok() {
            let fresh = folder::slashed(&path).and_then(|path| package.files().get(&path));
            let fresh = fresh.filter(|file| !matches!(file.content, Content::Kept(_)));
            let is_same = fresh.and_then(|file| file.content.read().ok()).is_some_and(|fresh| {
                read_file(&from, fresh.len() as u64)
                    .is_ok_and(|disk| equality::same(Equality::Bytes, &fresh, &disk))
            });
            if is_same || (is_folder && to.is_dir()) {
                continue;
            }
            return Err(conflict());
        }
        let parent = to.parent().unwrap_or(into);
        if parent
            .ancestors()
            .any(|folder| fs::symlink_metadata(folder).is_ok_and(|found| !found.is_dir()))
        {
            return Err(conflict());
        }
        let done = fs::create_dir_all(parent)
            .and_then(|()| if is_folder { fs::create_dir(&to) } else { link(&from, &to) });
        done.map_err(|e| {
            error("cannot be carried over").source(e).remedy("move it out of the output folder")
        })?;
        carried.push(path);
    }
    Ok(carried)
}

/// A hard link where the file system supports it, otherwise a copy.
fn link(from: &Path, to: &Path) -> io::Result<()> {
    fs::hard_link(from, to).or_else(|_| fs::copy(from, to).and_then(|_| File::open(to)?.sync_all()))
}

/// Moves foreign files that appeared in the old output while the new one was built.
fn adopt_latecomers(old: &Folder, now_at: &Path, root: &Path, carried: &[PathBuf]) {
    let moved = Folder {
        root: now_at.to_owned(),
        listed: old.listed.clone(),
        gaps: Vec::new(),
        has_manifest: old.has_manifest,
    };
    for path in moved.foreign().unwrap_or_default() {
        let to = root.join(&path);
        if carried.binary_search(&path).is_err() && fs::symlink_metadata(&to).is_err() {
            let made = to.parent().map_or(Ok(()), fs::create_dir_all);
            // Only if even this fails is the file removed with the old folder.
            let _ = made.and_then(|()| fs::rename(now_at.join(&path), &to));
        }
    }
}

/// Exchanges two folders, in one step where the system supports it.
///
/// Elsewhere the old folder is first renamed to `OUT.old-PID`. A crash between the two renames leaves it there,
/// complete, and the next run renames it back ([`restore_set_aside`]).
fn exchange(new: &Path, out: &Path) -> io::Result<()> {
    #[cfg(any(target_os = "linux", target_vendor = "apple"))]
    {
        use rustix::fs::{CWD, RenameFlags, renameat_with};
        use rustix::io::Errno;
        match renameat_with(CWD, new, CWD, out, RenameFlags::EXCHANGE) {
            Ok(()) => return Ok(()),
            // The file system or an old kernel does not support the exchange.
            Err(Errno::NOSYS | Errno::INVAL | Errno::NOTSUP) => {}
            Err(e) => return Err(e.into()),
        }
    }
    exchange_in_steps(new, out)
}

fn exchange_in_steps(new: &Path, out: &Path) -> io::Result<()> {
    let mut aside = out.as_os_str().to_owned();
    aside.push(format!(".old-{}", std::process::id()));
    let aside = PathBuf::from(aside);
    fs::rename(out, &aside)?;
    if let Err(e) = fs::rename(new, out) {
        fs::rename(&aside, out)?;
        return Err(e);
    }
    fs::rename(&aside, new)
}

fn restore_set_aside(root: &Path) -> io::Result<()> {
    if fs::symlink_metadata(root).is_ok() {
        return Ok(());
    }
    match siblings(root, ".old-")?.first() {
        Some(aside) => fs::rename(aside, root),
        None => Ok(()),
    }
}

/// Removes `OUT.tmp-PID` folders that no running process has locked.
fn remove_stale(root: &Path) -> io::Result<()> {
    for path in siblings(root, ".tmp-")? {
        if let Some(_lock) = lock_folder(&path) {
            match fs::remove_dir_all(&path) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
                _ => {}
            }
        }
    }
    Ok(())
}

/// Whether there are no leftover folders of aborted runs beside the output.
pub(super) fn is_tidy(root: &Path) -> bool {
    [".tmp-", ".old-"].iter().all(|mark| siblings(root, mark).is_ok_and(|found| found.is_empty()))
}

/// Folders whose name is `ROOT`, a mark and digits.
fn siblings(root: &Path, mark: &str) -> io::Result<Vec<PathBuf>> {
    let (Some(parent), Some(name)) =
        (root.parent(), root.file_name().and_then(|name| name.to_str()))
    else {
        return Ok(Vec::new());
    };
    let prefix = format!("{name}{mark}");
    let mut found = Vec::new();
    for entry in fs::read_dir(parent)? {
        let entry = entry?;
        let name = entry.file_name();
        let digits = name.to_str().and_then(|name| name.strip_prefix(&prefix));
        let is_process =
            digits.is_some_and(|d| !d.is_empty() && d.chars().all(|c| c.is_ascii_digit()));
        if is_process && entry.file_type()?.is_dir() {
            found.push(entry.path());
        }
    }
    found.sort();
    Ok(found)
}

/// The lock that marks a temporary folder as in use. The system releases it when the process ends, however it ends.
#[cfg(unix)]
fn lock_folder(path: &Path) -> Option<File> {
    let folder = File::open(path).ok()?;
    rustix::fs::flock(&folder, rustix::fs::FlockOperation::NonBlockingLockExclusive).ok()?;
    Some(folder)
}

/// Without such locks no folder counts as abandoned.
#[cfg(not(unix))]
fn lock_folder(_path: &Path) -> Option<File> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exchange_in_steps_ends_like_the_atomic_one() {
        let base = tempfile::tempdir().unwrap();
        let (new, out) = (base.path().join("new"), base.path().join("out"));
        for (folder, text) in [(&new, "new"), (&out, "old")] {
            fs::create_dir(folder).unwrap();
            fs::write(folder.join("text"), text).unwrap();
        }
        exchange_in_steps(&new, &out).unwrap();
        assert_eq!(fs::read_to_string(out.join("text")).unwrap(), "new");
        assert_eq!(fs::read_to_string(new.join("text")).unwrap(), "old");
        assert_eq!(fs::read_dir(base.path()).unwrap().count(), 2);
    }

    #[test]
    fn an_output_set_aside_by_a_crash_comes_back() {
        let base = tempfile::tempdir().unwrap();
        let aside = base.path().join("out.old-4711");
        fs::create_dir(&aside).unwrap();
        fs::write(aside.join("text"), "old").unwrap();
        restore_set_aside(&base.path().join("out")).unwrap();
        assert_eq!(fs::read_to_string(base.path().join("out/text")).unwrap(), "old");
    }
}
