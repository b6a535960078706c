//! A record of what a run read and wrote, so that the next run can see that it has nothing to do.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::disk::{clear, read_regular, resolve, write_whole};
use crate::error::{Error, Result};
use crate::hash::sha256;
use crate::input::read_file;

use super::{MAX_MANIFEST_BYTES, Package, write};

/// Hashes of everything that a package was made from, and of the bytes of every file in it. It is kept outside the
/// package, on the machine that made it, because numbers may differ in their last digits between processors.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    /// Hash of the inputs, including the program.
    pub inputs: String,
    /// The notes that the run printed.
    pub notes: Vec<String>,
    /// SHA-256 of every file by its path, hexadecimal.
    files: BTreeMap<String, String>,
    /// Size of all files, bytes.
    pub bytes: u64,
}

impl Stamp {
    /// The stamp of a sealed package. Time: one hash of every file, on all cores.
    pub fn new(package: &Package, inputs: String, notes: Vec<String>) -> Result<Stamp> {
        let files: Vec<_> = package.files().iter().collect();
        let hashes = files.into_par_iter().map(|(path, file)| {
            let bytes = file.content.read()?;
            Ok((path.clone(), (sha256(&bytes), bytes.len() as u64)))
        });
        let hashes: Vec<(String, (String, u64))> = hashes.collect::<Result<_>>()?;
        let bytes = hashes.iter().map(|(_, (_, bytes))| bytes).sum();
        let files = hashes.into_iter().map(|(path, (hash, _))| (path, hash)).collect();
        Ok(Stamp { inputs, notes, files, bytes })
    }

    /// Reads a stamp. `None` if there is no readable one.
    pub fn read(file: &Path) -> Option<Stamp> {
        serde_json::from_slice(&read_file(file, MAX_MANIFEST_BYTES).ok()?).ok()
    }

    /// Writes the stamp.
    pub fn write(&self, file: &Path) -> Result<()> {
        let error = || {
            Error::new(file.display(), "cannot be written")
                .remedy("check permissions and free space")
        };
        let text = serde_json::to_vec(self).map_err(|e| error().source(e))?;
        let folder = file.parent().map_or(Ok(()), fs::create_dir_all);
        folder.map_err(|e| error().source(e))?;
        clear(file);
        write_whole(file, &text)
    }

    /// Whether a folder has every file exactly as written, and no leftovers of aborted runs. Foreign files do not
    /// count. Time: one hash of every file, on all cores.
    pub fn holds(&self, out: &Path) -> bool {
        let Ok(root) = resolve(out) else { return false };
        let is_same = |(path, expected): (&String, &String)| {
            read_regular(&root.join(path)).is_ok_and(|bytes| sha256(&bytes) == *expected)
        };
        write::is_tidy(&root)
            && !self.files.is_empty()
            && self.files.iter().collect::<Vec<_>>().into_par_iter().all(is_same)
    }

    /// Number of files.
    pub fn file_count(&self) -> usize {
        self.files.len()
    }
}
