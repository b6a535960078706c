//! An output folder: whether it is a package, which files its manifest lists, which files are foreign.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::{Error, Result};
use crate::input::read_file;

use super::{Gap, Listed, MANIFEST, MAX_MANIFEST_BYTES, is_plain};

/// An output folder that exists.
pub(super) struct Folder {
    /// Path without symbolic links.
    pub(super) root: PathBuf,
    /// Files that its manifest lists, without the manifest itself. Empty for an empty folder.
    pub(super) listed: BTreeMap<String, Listed>,
    /// The variants that its manifest says were left out.
    pub(super) gaps: Vec<Gap>,
    /// Whether it has a package's manifest.
    pub(super) has_manifest: bool,
}

/// The folder next to `out` in which this process builds: `OUT.tmp-PID`.
pub fn temporary_folder(out: &Path) -> Result<PathBuf> {
    sibling(&resolve(out)?, &format!(".tmp-{}", std::process::id()))
}

/// Opens an output folder. Returns `None` if it is absent. It is an error if the folder is not empty and not a package.
pub(super) fn open(out: &Path) -> Result<Option<Folder>> {
    let root = resolve(out)?;
    let error = |cause: &str| Error::new(format!("output {}", out.display()), cause);
    match fs::metadata(&root) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(error("cannot be read").source(e).remedy("check its permissions")),
        Ok(found) if !found.is_dir() => {
            return Err(error("is not a folder").remedy("name another folder with --out"));
        }
        Ok(_) => {}
    }
    let unreadable = |e| error("cannot be read").source(e).remedy("check its permissions");
    let mut entries = fs::read_dir(&root).map_err(unreadable)?;
    if entries.next().is_none() {
        return Ok(Some(Folder {
            root,
            listed: BTreeMap::new(),
            gaps: Vec::new(),
            has_manifest: false,
        }));
    }
    let manifest = read_file(&root.join(MANIFEST), MAX_MANIFEST_BYTES).ok();
    let manifest = manifest.and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok());
    let manifest = manifest.filter(|value| value.get("generated_by").is_some_and(Value::is_string));
    let Some(manifest) = manifest else {
        let cause =
            format!("is neither empty nor a package: it has files, but no {MANIFEST} of a package");
        return Err(
            error(&cause).remedy("name another folder with --out, or empty this one yourself")
        );
    };
    let gaps = manifest.get("gaps").cloned().and_then(|gaps| serde_json::from_value(gaps).ok());
    let files = manifest.get("files").and_then(Value::as_object);
    let mut listed = BTreeMap::new();
    for (path, value) in files.into_iter().flatten().filter(|(path, _)| is_plain(path)) {
        if let Ok(file) = serde_json::from_value(value.clone()) {
            listed.insert(path.clone(), file);
        }
    }
    Ok(Some(Folder { root, listed, gaps: gaps.unwrap_or_default(), has_manifest: true }))
}

impl Folder {
    /// Files, links and empty folders that the manifest does not list: paths relative to the root, sorted.
    pub(super) fn foreign(&self) -> Result<Vec<PathBuf>> {
        let mut found = Vec::new();
        self.walk(Path::new(""), &mut found).map_err(|e| {
            Error::new(self.root.display(), "cannot be listed")
                .source(e)
                .remedy("check its permissions")
        })?;
        found.sort();
        Ok(found)
    }

    /// Whether a path relative to the root is part of the package.
    fn owns(&self, path: &Path) -> bool {
        let Some(path) = slashed(path) else { return false };
        (path == MANIFEST && self.has_manifest) || self.listed.contains_key(&path)
    }

    fn walk(&self, relative: &Path, found: &mut Vec<PathBuf>) -> io::Result<()> {
        let mut is_empty = true;
        for entry in fs::read_dir(self.root.join(relative))? {
            let entry = entry?;
            is_empty = false;
            let path = relative.join(entry.file_name());
            if entry.file_type()?.is_dir() {
                self.walk(&path, found)?;
            } else if !self.owns(&path) {
                found.push(path);
            }
        }
        if is_empty && relative != Path::new("") {
            found.push(relative.to_owned());
        }
        Ok(())
    }
}

/// A relative path with `/`; `None` if it is not valid Unicode.
pub(super) fn slashed(path: &Path) -> Option<String> {
    let parts: Option<Vec<&str>> = path.iter().map(|part| part.to_str()).collect();
    Some(parts?.join("/"))
}

/// The path of `out` without symbolic links, whether the folder exists or not.
pub(super) fn resolve(out: &Path) -> Result<PathBuf> {
    let error = |cause: &str| Error::new(format!("output {}", out.display()), cause);
    if let Ok(root) = fs::canonicalize(out) {
        return Ok(root);
    }
    if fs::symlink_metadata(out).is_ok() {
        let cause = "is a symbolic link to a folder that does not exist";
        return Err(error(cause).remedy("remove the link, or name another folder with --out"));
    }
    let Some(name) = out.file_name() else {
        return Err(error("is not the path of a folder").remedy("name a folder with --out"));
    };
    let parent = match out.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let parent = fs::canonicalize(parent).unwrap_or_else(|_| parent.to_owned());
    Ok(parent.join(name))
}

/// `ROOT` with a suffix added to its name.
pub(super) fn sibling(root: &Path, suffix: &str) -> Result<PathBuf> {
    let Some(name) = root.file_name() else {
        let error =
            Error::new(format!("output {}", root.display()), "is the root of the file system")
                .remedy("name a folder below it with --out");
        return Err(error);
    };
    let mut name = OsString::from(name);
    name.push(suffix);
    Ok(root.with_file_name(name))
}
