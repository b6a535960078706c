//! Whose a file is, for messages and for the decision whether it can be removed.

use std::fs;
use std::path::Path;

/// The owner of a file or folder in words, such as `root`; a number if the system has no name for it.
#[cfg(unix)]
pub fn owner(path: &Path) -> Option<String> {
    use std::os::unix::fs::MetadataExt;
    let id = fs::symlink_metadata(path).ok()?.uid();
    let users = fs::read_to_string("/etc/passwd").unwrap_or_default();
    let name = users.lines().find_map(|line| {
        let mut fields = line.split(':');
        let (name, number) = (fields.next()?, fields.nth(1)?);
        (number.parse() == Ok(id)).then(|| name.to_owned())
    });
    Some(name.unwrap_or_else(|| id.to_string()))
}

/// Elsewhere owners have no such names.
#[cfg(not(unix))]
pub fn owner(_path: &Path) -> Option<String> {
    None
}

/// Whether this user may be expected to change or remove it: it is the user's own, or the user may do everything.
#[cfg(unix)]
pub fn touchable(path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let own = rustix::process::geteuid().as_raw();
    own == 0 || fs::symlink_metadata(path).is_ok_and(|found| found.uid() == own)
}

/// Elsewhere only the attempt tells.
#[cfg(not(unix))]
pub fn touchable(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}
