//! Builds the harness's program if it is missing or older than its sources.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

use anyhow::{Context, Result, bail};
use diffraction_cli::harness::NAME;

use crate::root;

/// Its sources, relative to the workspace.
const SOURCES: [&str; 9] = [
    "Cargo.lock",
    "Cargo.toml",
    "cli/Cargo.toml",
    "cli/src",
    "harness/Cargo.toml",
    "harness/python",
    "harness/src",
    "src",
    "templates",
];

/// Path of the program, up to date: in the folder `release` of this program's target folder.
pub(crate) fn harness() -> Result<PathBuf> {
    let own = std::env::current_exe().context("the path of this program cannot be found")?;
    let target = own.ancestors().nth(2).context("this program is not in a target folder")?;
    let release = target.join("release");
    let path = release.join(format!("{NAME}{}", std::env::consts::EXE_SUFFIX));
    // cargo does not touch a program if its sources changed only in their time
    let looked_at = release.join(format!(".{NAME}-looked-at"));
    let known = modified(&path).map(|built| modified(&looked_at).map_or(built, |at| at.max(built)));
    if let Some(known) = known
        && newest(root(), &SOURCES).is_none_or(|newest| newest <= known)
    {
        return Ok(path);
    }
    eprintln!("note: building {NAME}: the first build takes about 5 minutes on two cores");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args(["build", "--release", "-p", NAME, "--target-dir"])
        .arg(target)
        .current_dir(root())
        .status()
        .context("cargo cannot be started; install Rust")?;
    if !status.success() {
        bail!("{NAME} could not be built; see cargo's messages above");
    }
    // without this mark the next call only runs cargo again
    let _ = File::create(looked_at);
    Ok(path)
}

fn modified(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).ok()?.modified().ok()
}

/// Time of the last change in files and folders with all their content; `None` if they do not exist.
fn newest(root: &Path, places: &[&str]) -> Option<SystemTime> {
    places.iter().filter_map(|place| newest_in(&root.join(place))).max()
}

fn newest_in(path: &Path) -> Option<SystemTime> {
    let inside = fs::read_dir(path).into_iter().flatten().flatten();
    inside.filter_map(|entry| newest_in(&entry.path())).chain(modified(path)).max()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_it_is_made_of_is_there() {
        let missing: Vec<_> = SOURCES.iter().filter(|place| !root().join(place).exists()).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }

    #[test]
    fn a_new_file_deep_inside_counts() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(newest(folder.path(), &["none"]), None);
        fs::create_dir_all(folder.path().join("a/b")).expect("a folder");
        let before = newest(folder.path(), &["a"]).expect("a folder");
        std::thread::sleep(std::time::Duration::from_millis(20));
        fs::write(folder.path().join("a/b/c"), "").expect("a file");
        assert!(newest(folder.path(), &["a"]).expect("a file") > before);
    }
}
