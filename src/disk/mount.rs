//! Mounts. What is mounted inside a folder is not that folder's: nothing here crosses into it.

use std::fs;
use std::io;
use std::path::Path;

/// Whether a file or folder is where another file system begins, or a part of the same one that is mounted there. Links
/// are not followed.
pub fn is_mount(path: &Path) -> io::Result<bool> {
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{AtFlags, CWD, StatxAttributes, StatxFlags, statx};
        let found = statx(CWD, path, AtFlags::SYMLINK_NOFOLLOW, StatxFlags::BASIC_STATS);
        // kernels before 5.8 do not know, and a filter of system calls may refuse the question
        if let Ok(found) = found
            && found.stx_attributes_mask.contains(StatxAttributes::MOUNT_ROOT)
        {
            return Ok(found.stx_attributes.contains(StatxAttributes::MOUNT_ROOT));
        }
    }
    is_other_device(path)
}

#[cfg(unix)]
fn is_other_device(path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let parent = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        Some(_) => Path::new("."),
        None => return Ok(true),
    };
    Ok(fs::symlink_metadata(path)?.dev() != fs::metadata(parent)?.dev())
}

#[cfg(not(unix))]
fn is_other_device(_path: &Path) -> io::Result<bool> {
    Ok(false)
}

/// Removes a folder with everything in it, unless something is mounted there: then nothing is removed.
pub fn remove_tree(folder: &Path) -> io::Result<()> {
    if has_mount(folder)? {
        let cause = "something is mounted in it";
        return Err(io::Error::new(io::ErrorKind::ResourceBusy, cause));
    }
    fs::remove_dir_all(folder)
}

fn has_mount(folder: &Path) -> io::Result<bool> {
    if is_mount(folder)? {
        return Ok(true);
    }
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let found = match entry.file_type()?.is_dir() {
            true => has_mount(&entry.path())?,
            false => is_mount(&entry.path())?,
        };
        if found {
            return Ok(true);
        }
    }
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_no_mounts_and_the_roots_of_file_systems_are() {
        let place = tempfile::tempdir().expect("a folder");
        fs::create_dir_all(place.path().join("a/b")).expect("a folder");
        assert!(!is_mount(&place.path().join("a")).expect("there"));
        assert!(is_mount(&place.path().join("absent")).is_err());
        if cfg!(target_os = "linux") {
            assert!(is_mount(Path::new("/proc")).expect("there"));
            assert!(remove_tree(Path::new("/proc")).is_err());
        }
        remove_tree(&place.path().join("a")).expect("nothing is mounted there");
        assert!(!place.path().join("a").exists());
    }
}
