//! What a file of a package holds, and where that is until the package is written.

use std::borrow::Cow;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::disk::{Spilled, open_regular};
use crate::error::{Error, Result};
use crate::hash::hex;
use crate::tables::{Table, TexelFormat};

/// What a file holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Content {
    /// Freshly generated, in memory.
    Bytes(Vec<u8>),
    /// Freshly generated, in a file outside the output folder that stays until the package is written or checked. It is
    /// verified whenever it is read.
    Stored {
        /// The file.
        file: PathBuf,
        /// SHA-256 of what it must hold, hexadecimal.
        sha256: String,
    },
    /// Freshly generated, in a file without a name that goes with the run.
    Spilled(Spilled),
    /// Taken over unchanged from the output folder (a partial rebuild).
    Kept(PathBuf),
}

impl Content {
    /// All of it.
    pub fn read(&self) -> Result<Cow<'_, [u8]>> {
        match self {
            Content::Bytes(bytes) => Ok(Cow::Borrowed(bytes)),
            _ => {
                let mut bytes = Vec::new();
                self.copy_to(&mut bytes).map_err(|e| self.unreadable(e))?;
                Ok(Cow::Owned(bytes))
            }
        }
    }

    /// A table with the (rounded) numbers of these bytes. They are read in parts, since as numbers they take more space.
    pub(super) fn table(&self, shape: Table) -> Result<Table> {
        let texels = Vec::with_capacity(shape.texel_count() * shape.format.channels());
        let mut decoded = Decoded { format: shape.format, rest: Vec::new(), texels };
        self.copy_to(&mut decoded).map_err(|e| self.unreadable(e))?;
        Ok(Table { texels: decoded.texels, ..shape })
    }

    /// Its size in bytes.
    pub fn byte_count(&self) -> Result<u64> {
        match self {
            Content::Bytes(bytes) => Ok(bytes.len() as u64),
            Content::Spilled(part) => Ok(part.byte_count()),
            Content::Stored { file, .. } | Content::Kept(file) => {
                std::fs::metadata(file).map(|found| found.len()).map_err(|e| self.unreadable(e))
            }
        }
    }

    /// Its SHA-256, hexadecimal, where that is known without reading it.
    pub(super) fn known_sha256(&self) -> Option<&str> {
        match self {
            Content::Stored { sha256, .. } => Some(sha256),
            Content::Spilled(part) => Some(part.sha256()),
            Content::Bytes(_) | Content::Kept(_) => None,
        }
    }

    /// Copies all of it in parts. Returns the number of bytes. It is an error if it is not any more what it was.
    pub(super) fn copy_to(&self, into: &mut impl Write) -> io::Result<u64> {
        match self {
            Content::Bytes(bytes) => into.write_all(bytes).map(|()| bytes.len() as u64),
            Content::Kept(file) => io::copy(&mut open_regular(file)?, into),
            Content::Stored { file, sha256 } => verified(open_regular(file)?, sha256, into),
            Content::Spilled(part) => verified(part.reader(), part.sha256(), into),
        }
    }

    fn unreadable(&self, error: io::Error) -> Error {
        let place = match self {
            Content::Stored { file, .. } | Content::Kept(file) => file.as_path(),
            Content::Bytes(_) | Content::Spilled(_) => Path::new("the folder of temporary files"),
        };
        Error::new(place.display(), "cannot be read").source(error).remedy("run it again")
    }
}

/// Texels as numbers, of bytes that come in parts of any length.
struct Decoded {
    format: TexelFormat,
    /// The beginning of the next texel.
    rest: Vec<u8>,
    texels: Vec<f64>,
}

impl Write for Decoded {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        /// A multiple of every texel's size.
        const PART: usize = 1 << 20;
        let taken = &bytes[..bytes.len().min(PART)];
        self.rest.extend_from_slice(taken);
        let whole = self.rest.len() / self.format.texel_bytes() * self.format.texel_bytes();
        self.texels.extend(self.format.decode(&self.rest[..whole]));
        self.rest.drain(..whole);
        Ok(taken.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Copies what a reader returns, which must have this hash.
fn verified(mut from: impl Read, sha256: &str, into: &mut impl Write) -> io::Result<u64> {
    let mut hasher = Sha256::new();
    let mut part = vec![0; 1 << 18];
    let mut length = 0;
    loop {
        let count = match from.read(&mut part) {
            Ok(0) => break,
            Ok(count) => count,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
            Err(e) => return Err(e),
        };
        hasher.update(&part[..count]);
        into.write_all(&part[..count])?;
        length += count as u64;
    }
    match hex(&hasher.finalize()) == sha256 {
        true => Ok(length),
        false => Err(io::Error::other("a finished table changed while it was used; run it again")),
    }
}
