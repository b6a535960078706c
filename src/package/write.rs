//! Writing a package: one run at a time, whole, and without touching what is not ours.
//!
//! A package is built beside the output and exchanged with it in one step; where that cannot be, it is built inside and
//! moved to its place. So neither readers nor crashes ever see half of it.

use std::path::{Path, PathBuf};

use crate::disk::{Access, FolderLock, is_mount};
use crate::error::{Error, Result};

use super::folder::{self, Folder, Foreign, Kind, slashed};
use super::leftover::{self, LeftBehind};
use super::{Cancel, Content, Equality, Package, equality, exchange, in_place};

/// Result of a write.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteReport {
    /// Number of files of the package.
    pub files: usize,
    /// Their total size.
    pub bytes: u64,
    /// Files of the previous package that were removed.
    pub removed: Vec<String>,
    /// Foreign files, folders and mounts that were kept.
    pub carried: Vec<PathBuf>,
    /// What earlier runs left and this user cannot remove, and what this run could not remove.
    pub left_behind: Vec<LeftBehind>,
    /// Whether the output was exchanged in one step. Otherwise its files were, one by one.
    pub exchanged: bool,
}

/// An output folder that this process alone writes to. Others wait until it is dropped.
#[derive(Debug)]
pub struct Output {
    lock: FolderLock,
    out: PathBuf,
    cancel: Cancel,
    left_behind: Vec<LeftBehind>,
}

impl Output {
    /// Locks `out`, which must be absent, empty or a package that the command of `generated_by` wrote
    /// ([`super::GENERATED_BY`] for packages). While another process writes there, calls `waiting` once with a line to show,
    /// and waits. Completes or removes what aborted runs left.
    ///
    /// An absent folder is made; it goes again if nothing is written, or if `cancel` is cancelled and settled.
    pub fn open(
        out: &Path,
        generated_by: &str,
        cancel: &Cancel,
        waiting: &dyn Fn(&str),
    ) -> Result<Output> {
        let root = crate::disk::resolve(out)?;
        if root.file_name().is_none() {
            let error =
                Error::new(format!("output {}", root.display()), "is the root of the file system");
            return Err(error.remedy("name a folder below it with --out"));
        }
        let lock = FolderLock::take(out, Access::Write, waiting)?;
        cancel.created(lock.created());
        let mut left_behind = in_place::recover(lock.root())?;
        folder::open(lock.root(), generated_by)?;
        left_behind.extend(leftover::sweep(beside(lock.root())));
        Ok(Output { lock, out: out.to_owned(), cancel: cancel.clone(), left_behind })
    }

    /// Writes a package there. After any error the previous output is unchanged, unless the error says that the next run
    /// completes it.
    pub fn write(mut self, package: &Package) -> Result<WriteReport> {
        let cancel = self.cancel.clone();
        let _writing = cancel.begin(&self.out)?;
        let root = self.lock.root().to_owned();
        let old = folder::open(&root, package.generated_by())?;
        let old = old.unwrap_or_else(|| Folder { root: root.clone(), ..Folder::default() });
        let inventory = old.inventory()?;
        let Kept { carried, same } = kept(package, &old, &inventory.foreign)?;
        let can_exchange = !inventory.has_folders
            && inventory.foreign.iter().all(|foreign| foreign.kind == Kind::File)
            && is_mount(&root).is_ok_and(|is| !is)
            && !is_stood_in(&root);
        let mut report = WriteReport { left_behind: self.left_behind, ..WriteReport::default() };
        let exchanged = match can_exchange {
            true => exchange::write(package, &old, &same, &carried, &mut self.lock, &cancel)?,
            false => None,
        };
        report.exchanged = exchanged.is_some();
        let written = match exchanged {
            Some((written, left)) => {
                report.left_behind.extend(left);
                written
            }
            None => in_place::write(package, &old, &cancel)?,
        };
        let gone = |path: &&String| !package.files().contains_key(*path);
        report.removed = old.listed.keys().filter(gone).cloned().collect();
        (report.files, report.bytes, report.carried) = (written.files, written.bytes, carried);
        Ok(report)
    }
}

/// Writes a package to `out`, which must be absent, empty or a package. Waits for other processes that write there.
///
/// Foreign files are kept. After any error the previous output is unchanged, unless the error says that the next run
/// completes it. What aborted runs left is completed or removed.
pub fn write(package: &Package, out: &Path) -> Result<WriteReport> {
    write_unless(package, out, &Cancel::new())
}

/// Like [`write()`], until cancelled.
pub fn write_unless(package: &Package, out: &Path, cancel: &Cancel) -> Result<WriteReport> {
    Output::open(out, package.generated_by(), cancel, &|_| ())?.write(package)
}

/// Whether `out` may be written by the command that `generated_by` names; an error with the reason if not. Writes nothing.
/// While another process writes there, calls `waiting` once with a line to show, and waits.
pub fn is_free(out: &Path, generated_by: &str, waiting: &dyn Fn(&str)) -> Result<()> {
    let _lock = FolderLock::take(out, Access::Read, waiting)?;
    folder::open(out, generated_by).map(|_| ())
}

/// Folders of aborted runs beside an output.
fn beside(root: &Path) -> Vec<PathBuf> {
    let name = root.file_name().and_then(|name| name.to_str());
    match (root.parent(), name) {
        (Some(parent), Some(name)) => leftover::find(parent, &format!("{name}.tmp-"), true),
        _ => Vec::new(),
    }
}

/// Whether aborted runs left nothing that the next run could remove.
pub(super) fn is_tidy(root: &Path) -> bool {
    let inside = leftover::find(root, folder::STAGE, false);
    !leftover::has_removable(&inside) && !leftover::has_removable(&beside(root))
}

/// Whether this process works in the output: then so does the shell that it was started from, which would be left in a
/// folder that is gone.
fn is_stood_in(root: &Path) -> bool {
    let here = std::env::current_dir().and_then(std::fs::canonicalize);
    here.is_ok_and(|here| here.starts_with(root))
}

/// What becomes of foreign files.
#[derive(Default)]
struct Kept {
    /// Those that stay.
    carried: Vec<PathBuf>,
    /// Those that are files of the package, to the byte.
    same: Vec<String>,
}

/// What becomes of foreign files. It is an error if one is in the way.
fn kept(package: &Package, old: &Folder, foreign: &[Foreign]) -> Result<Kept> {
    let mut kept = Kept::default();
    for Foreign { path, kind } in foreign {
        let at = old.root.join(path);
        let conflict = || {
            let what = match kind {
                Kind::File => "foreign file",
                Kind::EmptyFolder | Kind::ClosedFolder => "foreign folder",
                Kind::Mount => "mount",
            };
            let remedy = match kind {
                Kind::Mount => "unmount it, or name another folder with --out",
                _ => "move it out of the output folder",
            };
            Error::new(format!("{what} {}", at.display()), "is in the way of a generated file")
                .remedy(remedy)
        };
        let name = slashed(path);
        let is_generated =
            |path: &Path| slashed(path).is_some_and(|path| package.files().contains_key(&path));
        if path.ancestors().skip(1).any(is_generated) {
            return Err(conflict());
        }
        let fresh = name.as_ref().and_then(|name| package.files().get(name));
        let below = name.as_ref().map(|name| format!("{name}/"));
        let next = below.as_ref().and_then(|below| package.files().range(below.clone()..).next());
        let holds =
            next.zip(below.as_ref()).is_some_and(|((path, _), below)| path.starts_with(below));
        match (fresh, kind) {
            (Some(file), Kind::File) => {
                let fresh = Some(file).filter(|file| !matches!(file.content, Content::Kept(_)));
                let is_same =
                    fresh.and_then(|file| file.content.read().ok()).is_some_and(|fresh| {
                        let disk = crate::disk::read_regular(&at);
                        disk.is_ok_and(|disk| equality::same(Equality::Bytes, &fresh, &disk))
                    });
                if !is_same {
                    return Err(conflict());
                }
                kept.same.extend(name);
            }
            (Some(_), _) => return Err(conflict()),
            (None, Kind::EmptyFolder) if holds => {}
            (None, _) if holds => return Err(conflict()),
            (None, _) => kept.carried.push(path.clone()),
        }
    }
    Ok(kept)
}
