//! Installs the gallery's libraries by npm, and by pip those of the Python example and of commands, in the recorded versions.

use std::{
    ffi::OsStr,
    fs,
    path::Path,
    process::{Command, Stdio},
};

use anyhow::Context as _;

use super::setup::Outcome;

/// Folder of the gallery, and its list of versions.
const GALLERY: &str = "gallery";
const LOCK: &str = "package-lock.json";
/// The script that installs from Python's package index, which checks the hashes of the lists.
const SETUP: &str = "harness/python/setup.py";
/// What it installs: kind, folder, list. The folder `target/tools` is the one of `.cargo/config.toml`.
const PYTHON: [[&str; 3]; 3] = [
    ["environment", "target/python", "examples/moderngl/requirements.txt"],
    ["environment", "target/tools/import", "harness/python/import.txt"],
    ["dxc", "target/tools/dxc", "harness/python/dxc.txt"],
];
/// Name of the copy of the list in the folder of installed libraries.
const STAMP: &str = "installed.txt";

/// Installs libraries that are missing or were installed by another list.
pub fn run(root: &Path) -> anyhow::Result<Outcome> {
    let gallery = root.join(GALLERY);
    let node_modules = gallery.join("node_modules");
    let npm = || call(&gallery, "npm", ["ci", "--no-fund", "--no-audit"]);
    if !unless_done(&gallery.join(LOCK), &node_modules, npm)? {
        eprintln!("{GALLERY}: npm ci failed; fix that, or pass --no-setup");
        return Ok(Outcome::Missing);
    }
    for [kind, folder, list] in PYTHON {
        if !call(root, "python3", [SETUP, kind, folder, list])? {
            eprintln!("{list}: cannot be installed into {folder}; fix that, or pass --no-setup");
            return Ok(Outcome::Missing);
        }
    }
    Ok(Outcome::Ready)
}

/// Runs `install`, unless the same list was installed before. Returns whether the folder now matches the list.
fn unless_done(
    list: &Path,
    folder: &Path,
    install: impl FnOnce() -> anyhow::Result<bool>,
) -> anyhow::Result<bool> {
    let wanted = fs::read(list).with_context(|| format!("{}: cannot be read", list.display()))?;
    let stamp = folder.join(STAMP);
    if fs::read(&stamp).is_ok_and(|done| done == wanted) {
        return Ok(true);
    }
    let installed = install()?;
    if installed {
        fs::write(&stamp, wanted).with_context(|| format!("{}: not written", stamp.display()))?;
    }
    Ok(installed)
}

/// Runs a program with its output on stderr. Returns whether it succeeded.
pub(super) fn call<const N: usize>(
    folder: &Path,
    program: impl AsRef<OsStr>,
    arguments: [&str; N],
) -> anyhow::Result<bool> {
    let name = program.as_ref().display().to_string();
    eprintln!("== setup: {name} {}", arguments.join(" "));
    let status = Command::new(&program)
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(std::io::stderr())
        .status();
    Ok(status.with_context(|| format!("{name} cannot be started"))?.success())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_is_installed_once() {
        let place = tempfile::tempdir().expect("a folder");
        let (list, folder) = (place.path().join("list"), place.path().join("folder"));
        fs::write(&list, "one").expect("writes");
        let install = || {
            fs::create_dir_all(&folder)?;
            Ok(true)
        };
        assert!(!unless_done(&list, &folder, || Ok(false)).expect("runs"));
        assert!(unless_done(&list, &folder, install).expect("runs"));
        let never = || panic!("it is done");
        assert!(unless_done(&list, &folder, never).expect("runs"));
        fs::write(&list, "two").expect("writes");
        assert!(!unless_done(&list, &folder, || Ok(false)).expect("runs"));
    }
}
