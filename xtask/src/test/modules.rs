//! Libraries of the gallery by npm and of the Python example by pip, in the versions that are written down.

use std::{
    ffi::OsStr,
    fs,
    path::Path,
    process::{Command, Stdio},
};

use anyhow::Context as _;

use super::setup::Outcome;

/// Where the gallery lies, and its versions in it.
const GALLERY: &str = "gallery";
const LOCK: &str = "package-lock.json";
/// What the Python example needs, and where it is put.
const REQUIREMENTS: &str = "examples/moderngl/requirements.txt";
const PYTHON: &str = "target/python";
/// Beside what was installed: the list that it was installed by.
const STAMP: &str = "installed.txt";

/// Installs what is missing or was installed by another list.
pub fn run(root: &Path) -> anyhow::Result<Outcome> {
    let gallery = root.join(GALLERY);
    let node_modules = gallery.join("node_modules");
    let npm = || call(&gallery, "npm", ["ci", "--no-fund", "--no-audit"]);
    if !unless_done(&gallery.join(LOCK), &node_modules, npm)? {
        eprintln!("{GALLERY}: npm ci failed: mend that, or pass --no-setup");
        return Ok(Outcome::Missing);
    }
    let python = root.join(PYTHON);
    let pip = || {
        let arguments =
            ["-m", "pip", "install", "-q", "--only-binary", ":all:", "-r", REQUIREMENTS];
        Ok(call(root, "python3", ["-m", "venv", PYTHON])?
            && call(root, python.join("bin/python"), arguments)?)
    };
    if !unless_done(&root.join(REQUIREMENTS), &python, pip)? {
        eprintln!(
            "{REQUIREMENTS}: cannot be installed into {PYTHON}: mend that, or pass --no-setup"
        );
        return Ok(Outcome::Missing);
    }
    Ok(Outcome::Ready)
}

/// Runs `install` unless it was done by the same list; says whether the folder is as the list wants it.
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

/// Runs a program, its report with the other diagnostics; says whether it succeeded.
fn call<const N: usize>(
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
