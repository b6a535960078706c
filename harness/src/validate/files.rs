//! The files of a folder that validators are to read.

use std::fs;
use std::path::{Path, PathBuf};

use diffraction_shaders::error::{Error, Result};

use super::Reads;

/// All files below a folder, sorted. Links are not followed.
pub(super) fn all_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    walk(folder, &mut files)?;
    files.sort();
    Ok(files)
}

fn walk(folder: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    let unreadable = |error| Error::new(folder.display(), "cannot be listed").source(error);
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let kind = entry.file_type().map_err(unreadable)?;
        if kind.is_dir() {
            walk(&entry.path(), files)?;
        } else if kind.is_file() {
            files.push(entry.path());
        }
    }
    Ok(())
}

/// A file's name.
pub(super) fn name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// A file's path below a folder.
pub(super) fn relative(file: &Path, folder: &Path) -> PathBuf {
    file.strip_prefix(folder).unwrap_or(file).to_owned()
}

/// Whether a package's file of this name is a shader.
pub(super) fn is_shader(name: &str) -> bool {
    [Reads::Wgsl, Reads::GlslHlsl, Reads::Spirv, Reads::Metal].iter().any(|kind| kind.name(name))
}
