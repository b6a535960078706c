//! A mesh's file, and the files that it names: buffers, materials, pictures.
//!
//! A mesh comes from anywhere, so its names must not reach beyond its own folder, and none of its files may be endless.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::input::read_file;

/// Maximum bytes of a mesh's file and all that it names, together.
pub(super) const MAX_BYTES: u64 = 512 << 20;
/// Maximum vertices of a mesh, after its parts are placed.
pub(super) const MAX_VERTICES: usize = 4 << 20;
/// Maximum triangles of a mesh, after its parts are placed.
pub(super) const MAX_TRIANGLES: usize = 8 << 20;

/// Maximum files that a mesh may name, each counted as often as it is named.
const MAX_FILES: u32 = 4096;

/// How names are to be.
const REMEDY: &str =
    "put the file beside the mesh or in a folder below it, and name it by a relative path";

/// The folder of a mesh, and how much may still be read.
pub(super) struct Named {
    /// The folder, without links.
    folder: PathBuf,
    left: u64,
    files: u32,
}

impl Named {
    /// Reads the mesh's own file.
    pub(super) fn open(path: &Path) -> Result<(Named, Vec<u8>)> {
        let fail = |error: io::Error| {
            Error::new(path.display(), "cannot be read")
                .source(error)
                .remedy("check the path; a mesh is a regular file of at most 512 MiB")
        };
        let bytes = read_file(path, MAX_BYTES).map_err(fail)?;
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let folder = fs::canonicalize(folder).map_err(fail)?;
        let left = MAX_BYTES - bytes.len() as u64;
        Ok((Named { folder, left, files: 0 }, bytes))
    }

    /// The content of a URI of glTF: `data:` with base64, or a relative path, which may have `%20` and the like.
    pub(super) fn uri(&mut self, uri: &str) -> Result<Vec<u8>> {
        let about = || format!("\"{}\"", shortened(uri));
        if let Some(data) = uri.strip_prefix("data:") {
            let Some((_, text)) = data.split_once(";base64,") else {
                return Err(Error::new(about(), "is not base64")
                    .remedy("use data:application/octet-stream;base64,…, or a file"));
            };
            let bytes = BASE64_STANDARD.decode(text).map_err(|error| {
                Error::new(about(), "is not valid base64").source(error.to_string())
            })?;
            self.spend(bytes.len() as u64).map_err(|cause| Error::new(about(), cause))?;
            return Ok(bytes);
        }
        if uri.contains(':') {
            return Err(Error::new(about(), "is not a relative path").remedy(REMEDY));
        }
        let path = percent_encoding::percent_decode_str(uri).decode_utf8().map_err(|error| {
            Error::new(about(), "is not text after percent-decoding").source(error)
        })?;
        self.file(&path)
    }

    /// The content of a file that the mesh names by a path relative to its folder.
    pub(super) fn file(&mut self, name: &str) -> Result<Vec<u8>> {
        let fail = |cause: &str| Error::new(format!("\"{}\"", shortened(name)), cause);
        let is_inside =
            |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
        let relative = Path::new(name);
        // a backslash separates folders on some systems only
        let is_plain = !name.is_empty() && !name.contains(['\\', '\0']);
        if !is_plain || !relative.components().all(is_inside) {
            return Err(fail("is not a relative path below the mesh's folder").remedy(REMEDY));
        }
        self.files += 1;
        if self.files > MAX_FILES {
            return Err(fail("is one file too many: a mesh may name 4096"));
        }
        let unreadable = |error: io::Error| fail(&error.to_string());
        let path = fs::canonicalize(self.folder.join(relative)).map_err(unreadable)?;
        if !path.starts_with(&self.folder) {
            return Err(fail("leads out of the mesh's folder through a link").remedy(REMEDY));
        }
        let bytes = read_file(&path, self.left).map_err(|error| match path.is_file() {
            true if error.kind() == io::ErrorKind::InvalidInput => fail(TOO_MUCH),
            _ => unreadable(error),
        })?;
        self.spend(bytes.len() as u64).map_err(|cause| fail(&cause))?;
        Ok(bytes)
    }

    fn spend(&mut self, bytes: u64) -> Result<(), String> {
        self.left = self.left.checked_sub(bytes).ok_or(TOO_MUCH)?;
        Ok(())
    }
}

const TOO_MUCH: &str = "brings the mesh's files above 512 MiB, the limit";

/// Content inside a file has long names.
fn shortened(name: &str) -> String {
    const SHOWN: usize = 80;
    match name.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}

/// Checks a count of vertices or triangles against its limit.
pub(super) fn within(count: usize, max: usize, what: &str) -> Result<(), String> {
    match count > max {
        true => Err(format!("has more than {max} {what}, the limit: simplify it")),
        false => Ok(()),
    }
}
