//! Space for what one run computes and does not keep: a file that has no name, so that nothing is left of it however the
//! run ends.

use std::fs::File;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};

use crate::hash::sha256;

/// A file without a name, in the folder of temporary files. It is made when it is first needed.
#[derive(Debug, Default)]
pub struct Spill(Mutex<Option<(Arc<File>, u64)>>);

/// A part of it. The space is given back with the last part.
#[derive(Clone, Debug)]
pub struct Spilled {
    file: Arc<File>,
    offset: u64,
    length: u64,
    sha256: String,
}

impl PartialEq for Spilled {
    fn eq(&self, other: &Spilled) -> bool {
        (self.length, &self.sha256) == (other.length, &other.sha256)
    }
}

impl Eq for Spilled {}

impl Spill {
    /// Space without a file yet.
    pub fn new() -> Spill {
        Spill::default()
    }

    /// Writes bytes there. Fails where the folder of temporary files has no room for them.
    pub fn keep(&self, bytes: &[u8]) -> io::Result<Spilled> {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (file, end) = match &mut *state {
            Some(made) => made,
            none => none.insert((Arc::new(tempfile::tempfile()?), 0)),
        };
        write_at(file, bytes, *end)?;
        let length = bytes.len() as u64;
        let part = Spilled { file: file.clone(), offset: *end, length, sha256: sha256(bytes) };
        *end += length;
        Ok(part)
    }
}

impl Spilled {
    /// Number of bytes.
    pub fn byte_count(&self) -> u64 {
        self.length
    }

    /// Their SHA-256, hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// All of them, from a place of one's own: several may read at the same time.
    pub fn reader(&self) -> impl io::Read + '_ {
        Reader { part: self, at: 0 }
    }
}

struct Reader<'a> {
    part: &'a Spilled,
    at: u64,
}

impl io::Read for Reader<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let left = usize::try_from(self.part.length - self.at).unwrap_or(usize::MAX);
        let wanted = left.min(into.len());
        let count = read_at(&self.part.file, &mut into[..wanted], self.part.offset + self.at)?;
        self.at += count as u64;
        Ok(count)
    }
}

#[cfg(unix)]
fn write_at(file: &File, bytes: &[u8], offset: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::write_all_at(file, bytes, offset)
}

#[cfg(unix)]
fn read_at(file: &File, into: &mut [u8], offset: u64) -> io::Result<usize> {
    std::os::unix::fs::FileExt::read_at(file, into, offset)
}

/// What cannot be written at a place stays in memory.
#[cfg(not(unix))]
fn write_at(_file: &File, _bytes: &[u8], _offset: u64) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(not(unix))]
fn read_at(_file: &File, _into: &mut [u8], _offset: u64) -> io::Result<usize> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(all(test, unix))]
mod tests {
    use std::io::Read;

    use super::*;

    #[test]
    fn parts_are_read_back_beside_each_other() {
        let spill = Spill::new();
        let parts = [vec![1; 70_000], vec![], vec![2; 5]].map(|bytes| (spill.keep(&bytes), bytes));
        for (part, bytes) in parts {
            let part = part.expect("there is room");
            let mut read = Vec::new();
            part.reader().read_to_end(&mut read).expect("reads");
            assert_eq!((&read, part.sha256()), (&bytes, sha256(&bytes).as_str()));
        }
    }
}
