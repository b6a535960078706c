//! Builds the files of a package in a folder that nobody else uses.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::Path;

use rayon::prelude::*;

use crate::error::{Error, Result};

use super::{Cancel, Package};

/// Number and total size of files.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Written {
    pub(super) files: usize,
    pub(super) bytes: u64,
}

/// Writes all files of a package below a folder, and passes them to the disk.
pub(super) fn build(
    package: &Package,
    into: &Path,
    out: &Path,
    cancel: &Cancel,
) -> Result<Written> {
    let mut written = Written::default();
    let mut folders = BTreeSet::from([into.to_owned()]);
    let fail = |path: &str, e: io::Error| {
        Error::new(format!("generated file {path}"), "cannot be written")
            .source(e)
            .remedy("check permissions and free space")
    };
    for (path, file) in package.files() {
        cancel.unless(out, || Ok(()))?;
        let at = into.join(path);
        let parent = at.parent().unwrap_or(into);
        let bytes = fs::create_dir_all(parent).and_then(|()| {
            let mut to = OpenOptions::new().write(true).create_new(true).open(&at)?;
            file.content.copy_to(&mut to)
        });
        written.files += 1;
        written.bytes += bytes.map_err(|e| fail(path, e))?;
        folders.insert(parent.to_owned());
    }
    // Files are synced after all are written: the first sync waits for the disk, and by then most others are on it.
    package.files().par_iter().try_for_each(|(path, _)| {
        cancel.unless(out, || Ok(()))?;
        File::open(into.join(path)).and_then(|file| file.sync_all()).map_err(|e| fail(path, e))
    })?;
    folders.iter().for_each(|folder| sync_folder(folder));
    Ok(written)
}

/// Gives what was built the owner of the output, if that is another user: root leaves outputs to whom they belong. Fails if
/// it cannot.
#[cfg(unix)]
pub(super) fn owned_like(out: &Path, built: &Path, package: &Package) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, lchown};
    let (was, is) = (fs::metadata(out)?, fs::metadata(built)?);
    if (was.uid(), was.gid()) == (is.uid(), is.gid()) {
        return Ok(());
    }
    let above = |path: &String| Path::new(path).ancestors().map(Path::to_owned).collect::<Vec<_>>();
    let all: BTreeSet<_> = package.files().keys().flat_map(above).collect();
    all.iter().try_for_each(|path| lchown(built.join(path), Some(was.uid()), Some(was.gid())))
}

#[cfg(not(unix))]
pub(super) fn owned_like(_out: &Path, _built: &Path, _package: &Package) -> io::Result<()> {
    Ok(())
}

/// Errors are ignored: a file system that cannot sync folders still renames them in order.
pub(super) fn sync_folder(path: &Path) {
    if let Ok(folder) = File::open(path) {
        let _ = folder.sync_all();
    }
}
