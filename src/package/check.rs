//! Comparison of a package with a folder, without writing.

use std::io;
use std::path::Path;

use crate::disk::{Access, FolderLock, open_regular, read_regular};
use crate::error::{Error, Result};

use crate::hash::sha256_of;

use super::folder::Kind;
use super::{Content, MANIFEST, Package, equality, folder};

/// How a folder differs from a package. Paths are relative, sorted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// In both, but different by more than the file's tolerance.
    pub changed: Vec<String>,
    /// How many of these have other line ends, and nothing else that is different.
    pub line_ends: usize,
    /// Only in the package.
    pub missing: Vec<String>,
    /// Listed in the folder's manifest but no longer in the package. The next run removes them.
    pub orphan: Vec<String>,
    /// Only in the folder and never part of a package. Every run carries them over.
    pub foreign: Vec<String>,
}

impl Report {
    /// Whether a run of `generate` would change anything. Foreign files do not count.
    pub fn is_stale(&self) -> bool {
        !(self.changed.is_empty() && self.missing.is_empty() && self.orphan.is_empty())
    }
}

/// Compares a package with a folder. In an absent folder every file is missing; a folder that is not a package is an error.
/// Waits while another process writes there, so that it sees one package. This process must not hold the folder itself.
pub fn check(package: &Package, out: &Path) -> Result<Report> {
    let _lock = FolderLock::take(out, Access::Read, &|_| ())?;
    let Some(old) = folder::open(out, package.generated_by())? else {
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
        let unreadable = |e| {
            Error::new(on_disk.display(), "cannot be read")
                .source(e)
                .remedy("check its permissions")
        };
        let mut has_other_ends = false;
        let is_same = match &file.content {
            Content::Kept(_) => true,
            // the bytes are nearly always the same, and this comparison does not load the whole file
            content if has_bytes(content.known_sha256(), &on_disk).map_err(unreadable)? => true,
            content => {
                let disk = read_regular(&on_disk).map_err(unreadable)?;
                let fresh = content.read()?;
                let is_same = equality::same(file.compare, &fresh, &disk);
                has_other_ends = !is_same && without_returns(&disk) == *fresh;
                is_same
            }
        };
        if !is_same {
            report.changed.push(path.clone());
            report.line_ends += usize::from(has_other_ends);
        }
    }
    let gone = |path: &&String| {
        !package.files().contains_key(*path)
            && *path != MANIFEST
            && old.root.join(path.as_str()).is_file()
    };
    report.orphan = old.listed.keys().filter(gone).cloned().collect();
    // Foreign files at a path that the package needs were reported above.
    let foreign = old.inventory()?.foreign.into_iter().filter_map(|foreign| {
        let path = foreign.path;
        let shown = folder::slashed(&path).unwrap_or_else(|| path.display().to_string());
        let is_shown = foreign.kind != Kind::EmptyFolder && !package.files().contains_key(&shown);
        is_shown.then_some(shown)
    });
    report.foreign = foreign.collect();
    Ok(report)
}

/// The bytes with CR LF replaced by LF.
fn without_returns(bytes: &[u8]) -> Vec<u8> {
    let is_kept = |(i, byte): &(usize, &u8)| **byte != b'\r' || bytes.get(i + 1) != Some(&b'\n');
    bytes.iter().enumerate().filter(is_kept).map(|(_, byte)| *byte).collect()
}

/// Whether a file has the hash that is known of its content.
fn has_bytes(sha256: Option<&str>, file: &Path) -> io::Result<bool> {
    let Some(sha256) = sha256 else { return Ok(false) };
    Ok(sha256_of(open_regular(file)?)? == sha256)
}
