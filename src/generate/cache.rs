//! Finished tables and probes in a folder, by their identity.
//!
//! The cache is only a saving: what cannot be read or written is computed, and then stays in memory.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::Result;
use crate::package::Content;

/// A folder, or none.
#[derive(Clone, Copy)]
pub(super) struct Cache<'a>(pub(super) Option<&'a Path>);

impl Cache<'_> {
    /// Bytes of that length, from the cache, or made and put there: a file of the cache where there is one.
    pub(super) fn content(
        self,
        id: &str,
        length: usize,
        make: impl FnOnce() -> Result<Vec<u8>>,
    ) -> Result<Content> {
        let Some(file) = self.file(id) else { return Ok(Content::Bytes(make()?)) };
        if fs::metadata(&file).is_ok_and(|found| found.len() == length as u64) {
            return Ok(Content::Stored(file));
        }
        let bytes = make()?;
        Ok(if store(&file, &bytes) { Content::Stored(file) } else { Content::Bytes(bytes) })
    }

    /// So many numbers, from the cache, or made and put there.
    pub(super) fn numbers(
        self,
        id: &str,
        count: usize,
        make: impl FnOnce() -> Result<Vec<f64>>,
    ) -> Result<Vec<f64>> {
        let file = self.file(id);
        if let Some(bytes) = file.as_ref().and_then(|file| fs::read(file).ok())
            && bytes.len() == 8 * count
        {
            return Ok(bytes
                .as_chunks()
                .0
                .iter()
                .map(|&eight| f64::from_le_bytes(eight))
                .collect());
        }
        let numbers = make()?;
        if let Some(file) = file {
            let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
            store(&file, &bytes);
        }
        Ok(numbers)
    }

    fn file(self, id: &str) -> Option<PathBuf> {
        self.0.map(|folder| folder.join(format!("{id}.bin")))
    }
}

/// Writes a whole file or none; whether it did.
fn store(file: &Path, bytes: &[u8]) -> bool {
    let partial = file.with_extension(format!("{}.partial", std::process::id()));
    let stored = file
        .parent()
        .map_or(Ok(()), fs::create_dir_all)
        .and_then(|()| fs::write(&partial, bytes))
        .and_then(|()| fs::rename(&partial, file));
    if stored.is_err() {
        let _ = fs::remove_file(&partial);
    }
    stored.is_ok()
}
