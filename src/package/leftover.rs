//! Folders in which a package is built. Each carries a mark, so that a later run knows what a killed run left, and removes
//! no folder of anybody else, whatever its name.

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::disk::{is_mount, owner, read_regular, touchable};

use super::MANIFEST;

/// The file that marks such a folder.
const MARK: &str = "diffraction.json";
/// The mark before it is complete.
const HALF_MARK: &str = "diffraction.json.new";
/// What the mark says of itself.
const LEFT_BY: &str =
    "diffraction-shaders builds a package here; if no run does, the next one removes the folder";
/// Ends the name of a folder that gets its mark, or has lost it.
const BARE: &str = ".diffraction";
/// The package, inside of such a folder.
pub(super) const BODY: &str = "new";
/// The manifest of the package that is being replaced in place.
pub(super) const OLD_MANIFEST: &str = "old-manifest.json";

/// What such a folder is for.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Mark {
    pub(super) left_by: String,
    /// Number of the folder [`BODY`] as it was made. Another folder in its place is the previous package.
    pub(super) inode: u64,
    /// Files of the package that is built, without its manifest.
    pub(super) new: BTreeSet<String>,
    /// Files that the manifest of the previous package lists.
    pub(super) old: BTreeSet<String>,
    /// Links to foreign files, which are in the output too.
    pub(super) carried: BTreeSet<String>,
    /// The package is complete, and its files are on their way to their places.
    pub(super) moving: bool,
}

/// A folder of an aborted run that could not be removed, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftBehind {
    /// The folder.
    pub path: PathBuf,
    /// Whose it is, where the system tells.
    pub owner: Option<String>,
    /// What the system said.
    pub cause: String,
}

impl fmt::Display for LeftBehind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LeftBehind { path, owner, cause } = self;
        write!(f, "{}: is left of a run and cannot be removed: {cause}", path.display())?;
        match owner {
            Some(owner) => write!(f, "; it belongs to user {owner} (remove it yourself)"),
            None => write!(f, " (remove it yourself)"),
        }
    }
}

impl LeftBehind {
    pub(super) fn new(path: &Path, cause: &io::Error) -> LeftBehind {
        let obstacle = first_of_others(path).unwrap_or_else(|| path.to_owned());
        LeftBehind { path: path.to_owned(), owner: owner(&obstacle), cause: cause.to_string() }
    }
}

impl Mark {
    /// The mark of a folder; `None` if it has none of ours.
    pub(super) fn read(folder: &Path) -> Option<Mark> {
        let bytes = read_regular(&folder.join(MARK)).ok()?;
        let mark: Mark = serde_json::from_slice(&bytes).ok()?;
        // foreign names may have signs that names of ours do not have
        let is_within = |path: &String| {
            Path::new(path).components().all(|part| matches!(part, Component::Normal(_)))
        };
        let paths = || mark.new.iter().chain(&mark.old).chain(&mark.carried);
        (mark.left_by == LEFT_BY && paths().all(is_within)).then_some(mark)
    }

    /// Writes the mark of a folder, whole.
    pub(super) fn write(&self, folder: &Path) -> io::Result<()> {
        let half = folder.join(HALF_MARK);
        let text = serde_json::to_vec(self).map_err(io::Error::other)?;
        fs::write(&half, text)?;
        fs::File::open(&half)?.sync_all()?;
        fs::rename(&half, folder.join(MARK))
    }
}

/// Makes the folder `BASE`, or `BASE-1`, … where the name is taken, with a mark and an empty [`BODY`].
pub(super) fn create(base: &Path, mut mark: Mark) -> io::Result<(PathBuf, Mark)> {
    let mut number = 0;
    let (path, bare) = loop {
        let path = match number {
            0 => base.to_owned(),
            number => suffixed(base, &format!("-{number}")),
        };
        let bare = suffixed(&path, BARE);
        let is_free = fs::symlink_metadata(&path).is_err();
        match if is_free { fs::create_dir(&bare) } else { Err(io::ErrorKind::AlreadyExists.into()) }
        {
            Ok(()) => break (path, bare),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists && number < 1000 => number += 1,
            Err(e) => return Err(e),
        }
    };
    LEFT_BY.clone_into(&mut mark.left_by);
    let made = fs::create_dir(bare.join(BODY)).and_then(|()| {
        mark.inode = inode(&bare.join(BODY));
        mark.write(&bare)?;
        fs::rename(&bare, &path)
    });
    match made {
        Ok(()) => Ok((path, mark)),
        Err(e) => {
            let _ = remove_bare(&bare);
            Err(e)
        }
    }
}

/// Removes such a folder: the files that the mark lists, links to foreign files that have another name elsewhere, and
/// folders that are empty then. If anything else is there, it stays, and that is an error.
pub(super) fn remove(folder: &Path) -> io::Result<()> {
    let Some(mark) = Mark::read(folder) else {
        return Err(io::Error::other("it carries no mark"));
    };
    let body = folder.join(BODY);
    if fs::symlink_metadata(&body).is_ok() {
        let is_new = inode(&body) == mark.inode;
        for path in if is_new { &mark.new } else { &mark.old } {
            remove_own(&body, path)?;
        }
        remove_own(&body, MANIFEST)?;
        for path in &mark.carried {
            if has_another_name(&body.join(path)) {
                remove_own(&body, path)?;
            }
        }
        prune(&body)?;
    }
    if let Some(other) = first_file(&body) {
        return Err(io::Error::other(format!("it holds {}", other.display())));
    }
    remove_own(folder, OLD_MANIFEST)?;
    let bare = suffixed(folder, BARE);
    fs::rename(folder, &bare)?;
    remove_bare(&bare)
}

/// Removes a folder that has a mark at most.
fn remove_bare(bare: &Path) -> io::Result<()> {
    for name in [BODY, HALF_MARK, MARK] {
        let path = bare.join(name);
        let done = if name == BODY { fs::remove_dir(path) } else { fs::remove_file(path) };
        done.or_else(|e| if e.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(e) })?;
    }
    fs::remove_dir(bare)
}

/// Folders of aborted runs beside `base`, or in the folder that holds it: their names begin with `PREFIX`, and digits
/// follow if `is_numbered`.
pub(super) fn find(place: &Path, prefix: &str, is_numbered: bool) -> Vec<PathBuf> {
    let is_name = |name: &str| {
        let rest = name.strip_prefix(prefix)?;
        let rest = rest.strip_suffix(BARE).unwrap_or(rest);
        let parts: Vec<&str> = rest.split('-').collect();
        let numbers = if is_numbered { &parts[..] } else { &parts[1..] };
        let is_number = |part: &&str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
        let is_whole = parts.len() <= 2 && (is_numbered || parts[0].is_empty());
        (is_whole && numbers.iter().all(is_number)).then_some(())
    };
    let mut found: Vec<PathBuf> = fs::read_dir(place)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_str().and_then(is_name).is_some())
        .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()))
        .map(|entry| entry.path())
        .filter(|path| is_ours(path))
        .collect();
    found.sort();
    found
}

/// Whether a folder carries our mark, or has a name that only a folder between having a mark and having none has, and
/// nothing of anybody else's.
fn is_ours(path: &Path) -> bool {
    let is_bare = path.as_os_str().to_string_lossy().ends_with(BARE);
    let is_part =
        |entry: fs::DirEntry| [BODY, HALF_MARK, MARK].iter().any(|name| entry.file_name() == *name);
    match is_bare {
        true => fs::read_dir(path).is_ok_and(|mut all| all.all(|entry| entry.is_ok_and(is_part))),
        false => Mark::read(path).is_some(),
    }
}

/// Removes what [`find`] found. Returns those that cannot be removed.
pub(super) fn sweep(found: Vec<PathBuf>) -> Vec<LeftBehind> {
    let mut left = Vec::new();
    for path in found {
        let is_bare = path.as_os_str().to_string_lossy().ends_with(BARE);
        let done = if is_bare { remove_bare(&path) } else { remove(&path) };
        match done {
            Err(e) if fs::symlink_metadata(&path).is_ok() => left.push(LeftBehind::new(&path, &e)),
            _ => {}
        }
    }
    left
}

/// Whether the next run could do something about any of these.
pub(super) fn has_removable(found: &[PathBuf]) -> bool {
    found.iter().any(|path| touchable(path))
}

/// Removes a file below a folder, unless the way to it leads through a link or into a mount, or it is a folder.
pub(super) fn remove_own(base: &Path, path: &str) -> io::Result<()> {
    let at = base.join(path);
    let is_file = || fs::symlink_metadata(&at).is_ok_and(|found| !found.is_dir());
    if !is_below(base, Path::new(path)) || !is_file() {
        return Ok(());
    }
    match fs::remove_file(&at) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

/// Whether all folders on the way from `base` to `path` are folders, not links, and nothing is mounted there.
pub(super) fn is_below(base: &Path, path: &Path) -> bool {
    let mut at = base.to_owned();
    path.parent().into_iter().flat_map(Path::iter).all(|part| {
        at.push(part);
        let is_folder = fs::symlink_metadata(&at).is_ok_and(|found| found.is_dir());
        is_folder && is_mount(&at).is_ok_and(|is| !is)
    })
}

/// Removes a folder and those below it as far as they are empty.
fn prune(folder: &Path) -> io::Result<()> {
    if is_mount(folder)? {
        return Ok(());
    }
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            prune(&entry.path())?;
        }
    }
    match fs::remove_dir(folder) {
        Err(e) if e.kind() != io::ErrorKind::DirectoryNotEmpty => Err(e),
        _ => Ok(()),
    }
}

/// Something that is left in a folder, by its path.
fn first_file(folder: &Path) -> Option<PathBuf> {
    let mut entries = fs::read_dir(folder).ok()?.flatten();
    let Some(entry) = entries.next() else { return Some(folder.to_owned()) };
    match entry.file_type() {
        Ok(kind) if kind.is_dir() => first_file(&entry.path()),
        _ => Some(entry.path()),
    }
}

/// The first file or folder, from the outside in, that this user does not own.
fn first_of_others(path: &Path) -> Option<PathBuf> {
    if !touchable(path) {
        return Some(path.to_owned());
    }
    let is_folder = fs::symlink_metadata(path).is_ok_and(|found| found.is_dir());
    let entries = if is_folder { fs::read_dir(path).ok() } else { None };
    entries?.flatten().find_map(|entry| first_of_others(&entry.path()))
}

#[cfg(unix)]
fn inode(path: &Path) -> u64 {
    use std::os::unix::fs::MetadataExt;
    fs::symlink_metadata(path).map_or(0, |found| found.ino())
}

/// Where folders have no numbers, none is exchanged.
#[cfg(not(unix))]
fn inode(_path: &Path) -> u64 {
    0
}

#[cfg(unix)]
fn has_another_name(path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    fs::symlink_metadata(path).is_ok_and(|found| found.nlink() > 1)
}

#[cfg(not(unix))]
fn has_another_name(_path: &Path) -> bool {
    false
}

/// A path with a suffix added to its name.
pub(super) fn suffixed(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}
