//! Writes a package into an output that cannot be exchanged: where something is mounted, where somebody stands in it, where
//! folders of others are in it, where folders cannot be moved.
//!
//! The package is built in a folder of the output, complete. From then on it counts: its files are moved to their places,
//! one by one, and a run that is killed meanwhile is completed by the next one. The manifest goes first and comes last, so
//! that no reader takes a mixture for a package.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::disk::is_mount;
use crate::error::{Error, Result};

use super::folder::{Folder, STAGE, whose};
use super::leftover::{self, BODY, LeftBehind, Mark, OLD_MANIFEST, is_below, remove_own};
use super::stage::{Written, build, owned_like, sync_folder};
use super::{Cancel, MANIFEST, Package};

/// Completes what a killed run began in an output, and removes what it did not complete. Returns what cannot be removed.
pub(super) fn recover(root: &Path) -> Result<Vec<LeftBehind>> {
    let stages = leftover::find(root, STAGE, false);
    for stage in &stages {
        if let Some(mark) = Mark::read(stage).filter(|mark| mark.moving) {
            finish(root, stage, &mark).map_err(|e| {
                Error::new(
                    format!("output {}", root.display()),
                    "cannot be completed after an aborted run",
                )
                .source(e)
                .remedy(format!("check its permissions{}", whose(stage)))
            })?;
        }
    }
    let is_there = |stage: &PathBuf| fs::symlink_metadata(stage).is_ok();
    Ok(leftover::sweep(stages.into_iter().filter(is_there).collect()))
}

/// Writes a package. Nothing foreign is touched.
pub(super) fn write(package: &Package, old: &Folder, cancel: &Cancel) -> Result<Written> {
    let root = &old.root;
    let new: BTreeSet<String> = package.files().keys().cloned().collect();
    let mark = Mark { new, old: old.listed.keys().cloned().collect(), ..Mark::default() };
    can_move(root, &mark)?;
    let unwritable = |e: io::Error| {
        Error::new(format!("output {}", root.display()), "cannot be written")
            .source(e)
            .remedy(format!("check its permissions and its free space{}", whose(root)))
    };
    let (stage, mut mark) = leftover::create(&root.join(STAGE), mark).map_err(unwritable)?;
    let done = build(package, &stage.join(BODY), root, cancel).and_then(|written| {
        // what belongs to whom is no reason to stop here
        let _ = owned_like(root, &stage.join(BODY), package);
        cancel.unless(root, || {
            mark.moving = true;
            mark.write(&stage).map_err(unwritable)?;
            sync_folder(&stage);
            finish(root, &stage, &mark).map_err(|e| {
                Error::new(format!("output {}", root.display()), "is written in part only")
                    .source(e)
                    .remedy("free the way and run it again: the next run completes it")
            })?;
            Ok(written)
        })
    });
    if done.is_err() && Mark::read(&stage).is_some_and(|mark| !mark.moving) {
        let _ = leftover::remove(&stage);
    }
    done
}

/// Whether all files can be moved, before anything is.
fn can_move(root: &Path, mark: &Mark) -> Result<()> {
    let mut folders = BTreeSet::from([root.to_owned()]);
    for path in mark.new.iter().chain(&mark.old) {
        let all = Path::new(path).ancestors().skip(1).map(|folder| root.join(folder));
        folders.extend(all.filter(|folder| fs::symlink_metadata(folder).is_ok()));
    }
    for folder in folders {
        let error = |cause: &str| Error::new(format!("output folder {}", folder.display()), cause);
        let way = "remove it from the output, or name another folder with --out";
        let found = fs::symlink_metadata(&folder);
        if !found.is_ok_and(|found| found.is_dir()) {
            return Err(error("is in the way of generated files: it is not a folder").remedy(way));
        }
        if folder != *root && is_mount(&folder).unwrap_or(true) {
            let cause = "is in the way of generated files: something else is mounted there";
            return Err(error(cause).remedy("unmount it, or name another folder with --out"));
        }
        if let Err(e) = writable(&folder) {
            let remedy = format!(
                "check its permissions, or name another folder with --out{}",
                whose(&folder)
            );
            return Err(error("cannot be written to").source(e).remedy(remedy));
        }
    }
    Ok(())
}

#[cfg(unix)]
fn writable(folder: &Path) -> io::Result<()> {
    use rustix::fs::{Access, access};
    Ok(access(folder, Access::WRITE_OK | Access::EXEC_OK)?)
}

#[cfg(not(unix))]
fn writable(folder: &Path) -> io::Result<()> {
    fs::metadata(folder).map(|_| ())
}

/// Moves the files of a complete package to their places and removes those of the previous one. May be called again after
/// it was killed at any moment.
fn finish(root: &Path, stage: &Path, mark: &Mark) -> io::Result<()> {
    let body = stage.join(BODY);
    let exists = |path: &Path| fs::symlink_metadata(path).is_ok();
    let (from, to) = (body.join(MANIFEST), root.join(MANIFEST));
    // once the new manifest has come, the rest has, too
    if exists(&from) {
        if exists(&to) {
            fs::rename(&to, stage.join(OLD_MANIFEST))?;
            sync_folder(root);
        }
        for path in mark.new.iter().filter(|path| *path != MANIFEST) {
            let (from, to) = (body.join(path), root.join(path));
            if exists(&from) {
                to.parent().map_or(Ok(()), fs::create_dir_all)?;
                if !is_below(root, Path::new(path)) {
                    let cause = format!("{path}: a link or a mount is in the way");
                    return Err(io::Error::other(cause));
                }
                fs::rename(from, to)?;
            }
        }
        for path in mark.old.difference(&mark.new) {
            remove_own(root, path)?;
        }
        for path in mark.old.difference(&mark.new) {
            let folders = Path::new(path).ancestors().skip(1);
            for folder in folders.filter(|folder| *folder != Path::new("")) {
                // only empty ones can be removed like this
                if !is_below(root, folder) || fs::remove_dir(root.join(folder)).is_err() {
                    break;
                }
            }
        }
        mark.new
            .iter()
            .filter_map(|path| root.join(path).parent().map(Path::to_owned))
            .collect::<BTreeSet<_>>()
            .iter()
            .for_each(|folder| sync_folder(folder));
        fs::rename(from, to)?;
        sync_folder(root);
    }
    leftover::remove(stage)
}
