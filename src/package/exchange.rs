//! Writes a package beside the output and exchanges the two in one step, so that nobody ever sees half of it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::disk::FolderLock;
use crate::error::{Error, Result};

use super::folder::{Folder, Kind, slashed};
use super::leftover::{self, BODY, LeftBehind, Mark};
use super::stage::{Written, build, owned_like, sync_folder};
use super::{Cancel, MANIFEST, Package};

/// The folder next to the output in which this process builds, removed when dropped.
struct Beside {
    path: PathBuf,
}

impl Drop for Beside {
    fn drop(&mut self) {
        let _ = leftover::remove(&self.path);
    }
}

/// Writes a package. `None`: this output cannot be exchanged, and nothing was changed.
///
/// `same`: foreign files that the package has, too; `carried`: the others, which get links in the new output.
pub(super) fn write(
    package: &Package,
    old: &Folder,
    same: &[String],
    carried: &[PathBuf],
    lock: &mut FolderLock,
    cancel: &Cancel,
) -> Result<Option<(Written, Option<LeftBehind>)>> {
    let root = old.root.clone();
    let Some(names) = carried.iter().map(|path| slashed(path)).collect::<Option<_>>() else {
        return Ok(None);
    };
    let mark = Mark {
        new: package.files().keys().cloned().collect(),
        old: old.listed.keys().chain(same).cloned().collect(),
        carried: names,
        ..Mark::default()
    };
    let base = leftover::suffixed(&root, &format!(".tmp-{}", std::process::id()));
    let beside = match leftover::create(&base, mark) {
        Ok((path, _)) => Beside { path },
        Err(e) if is_forbidden(&e) => return Ok(None),
        Err(e) => {
            let error = Error::new(base.display(), "cannot be written").source(e);
            return Err(error.remedy("check the free space of the folder that holds it"));
        }
    };
    let new = beside.path.join(BODY);
    let written = build(package, &new, &root, cancel)?;
    let is_linked = |path: &PathBuf| {
        let (from, to) = (root.join(path), new.join(path));
        let made = to.parent().map_or(Ok(()), fs::create_dir_all);
        made.and_then(|()| fs::hard_link(from, to)).is_ok()
    };
    if owned_like(&root, &new, package).is_err()
        || !carried.iter().all(is_linked)
        || !made_like(&root, &new)
    {
        return Ok(None);
    }
    // others who wait for the output find the new one locked, too
    let Some(new_lock) = crate::disk::lock_new(&new) else { return Ok(None) };
    let is_exchanged = cancel.unless(&root, || {
        let is_exchanged = swap(&new, &root);
        if is_exchanged {
            lock.also(new_lock);
            adopt_latecomers(old, &new, carried);
            sync_folder(root.parent().unwrap_or(&root));
        }
        Ok(is_exchanged)
    })?;
    if !is_exchanged {
        return Ok(None);
    }
    let left = leftover::remove(&beside.path).err();
    let left = left.filter(|_| fs::symlink_metadata(&beside.path).is_ok());
    let left = left.map(|e| LeftBehind::new(&beside.path, &e));
    if left.is_some() {
        // a second attempt would fail as well
        std::mem::forget(beside);
    }
    Ok(Some((written, left)))
}

/// Whether this place is none in which a folder can be made: the output may still be written to.
fn is_forbidden(e: &io::Error) -> bool {
    use io::ErrorKind::{InvalidFilename, PermissionDenied, ReadOnlyFilesystem};
    matches!(e.kind(), InvalidFilename | PermissionDenied | ReadOnlyFilesystem)
}

/// Exchanges two folders in one step. Fails where the system or the file system cannot do that, and where a folder is in
/// use as a mount.
fn swap(new: &Path, out: &Path) -> bool {
    #[cfg(any(target_os = "linux", target_vendor = "apple"))]
    {
        use rustix::fs::{CWD, RenameFlags, renameat_with};
        renameat_with(CWD, new, CWD, out, RenameFlags::EXCHANGE).is_ok()
    }
    #[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
    {
        let _ = (new, out);
        false
    }
}

/// Gives the new folder the permissions of the old one. Fails if it would differ from it.
#[cfg(unix)]
fn made_like(old: &Path, new: &Path) -> bool {
    let like = || -> io::Result<bool> {
        fs::set_permissions(new, fs::metadata(old)?.permissions())?;
        Ok(attributes(old)? == attributes(new)?)
    };
    like().unwrap_or(false)
}

#[cfg(not(unix))]
fn made_like(_old: &Path, _new: &Path) -> bool {
    true
}

/// The names of what a folder has beside its permissions, such as a list of users.
#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn attributes(folder: &Path) -> io::Result<Vec<u8>> {
    let mut names = Vec::with_capacity(1 << 16);
    match rustix::fs::listxattr(folder, rustix::buffer::spare_capacity(&mut names)) {
        Ok(_) => Ok(names),
        Err(rustix::io::Errno::NOTSUP) => Ok(Vec::new()),
        Err(e) => Err(e.into()),
    }
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn attributes(_folder: &Path) -> io::Result<Vec<u8>> {
    Ok(Vec::new())
}

/// Moves foreign files that came to the old output while the new one was built, and those that were replaced meanwhile.
fn adopt_latecomers(old: &Folder, now_at: &Path, carried: &[PathBuf]) {
    let moved = Folder {
        root: now_at.to_owned(),
        listed: old.listed.clone(),
        has_manifest: old.has_manifest || now_at.join(MANIFEST).exists(),
        ..Folder::default()
    };
    for foreign in moved.inventory().unwrap_or_default().foreign {
        let (from, to) = (now_at.join(&foreign.path), old.root.join(&foreign.path));
        let is_carried = carried.binary_search(&foreign.path).is_ok();
        let is_newer = is_carried && !is_same_file(&from, &to);
        let is_late = !is_carried && fs::symlink_metadata(&to).is_err();
        let made = || to.parent().map_or(Ok(()), fs::create_dir_all);
        // What fails stays where it is, and the caller says so.
        let _ = match foreign.kind {
            Kind::File if is_newer || is_late => made().and_then(|()| fs::rename(&from, &to)),
            Kind::EmptyFolder if is_late => fs::create_dir_all(&to),
            _ => Ok(()),
        };
    }
}

#[cfg(unix)]
fn is_same_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |path: &Path| fs::symlink_metadata(path).ok().map(|found| (found.dev(), found.ino()));
    id(a) == id(b)
}

#[cfg(not(unix))]
fn is_same_file(_a: &Path, _b: &Path) -> bool {
    true
}
