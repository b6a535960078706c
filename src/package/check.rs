//! Comparing a package with a folder, without writing.

use std::fs;
use std::path::Path;

use crate::error::{Error, Result, Stage};

use super::{Content, MANIFEST, Package, compare, folder};

/// How a folder differs from a package. Paths are relative, sorted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// In both, different beyond the tolerance of the file.
    pub changed: Vec<String>,
    /// In the package only.
    pub missing: Vec<String>,
    /// Listed by the manifest of the folder, no longer in the package: the next run removes them.
    pub orphan: Vec<String>,
    /// In the folder only and never ours: every run carries them over.
    pub foreign: Vec<String>,
}

impl Report {
    /// Whether a run of `generate` would change anything; foreign files are no reason.
    pub fn is_stale(&self) -> bool {
        !(self.changed.is_empty() && self.missing.is_empty() && self.orphan.is_empty())
    }
}

/// Compares a package with a folder; an absent folder lacks everything, one that is not ours is an error.
pub fn check(package: &Package, out: &Path) -> Result<Report> {
    let Some(old) = folder::open(out)? else {
        let missing = package.files().keys().cloned().collect();
        return Ok(Report { missing, ..Report::default() });
    };
    let mut report = Report::default();
    for (path, file) in package.files() {
        let on_disk = old.root.join(path);
        if !on_disk.is_file() {
            report.missing.push(path.clone());
            continue;
        }
        let Content::Bytes(fresh) = &file.content else { continue };
        let disk = fs::read(&on_disk).map_err(|e| {
            Error::new(Stage::Package, on_disk.display(), "cannot be read").source(e)
        })?;
        if !compare::same(file.compare, fresh, &disk) {
            report.changed.push(path.clone());
        }
    }
    let gone = |path: &&String| {
        !package.files().contains_key(*path)
            && *path != MANIFEST
            && old.root.join(path.as_str()).is_file()
    };
    report.orphan = old.listed.keys().filter(gone).cloned().collect();
    // A file at a path that the package needs was reported above.
    let foreign = old.foreign()?.into_iter().filter_map(|path| {
        let shown = folder::slashed(&path).unwrap_or_else(|| path.display().to_string());
        let is_folder = old.root.join(&path).symlink_metadata().is_ok_and(|found| found.is_dir());
        (!is_folder && !package.files().contains_key(&shown)).then_some(shown)
    });
    report.foreign = foreign.collect();
    Ok(report)
}
