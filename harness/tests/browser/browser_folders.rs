//! What a browser leaves in the folder of temporary files: nothing, however its command ends.
#![cfg(unix)]

use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

use crate::support::browser::browser;

const PLAN: &str = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 60 }
[[preset]]
name = "one"
terms = 19
"#;

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Place {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("tmp")).unwrap();
        fs::write(folder.path().join("plan.toml"), PLAN).unwrap();
        let rows = "20,0,20,180\n";
        let text = format!("theta_i,phi_i,theta_r,phi_r\n{rows}");
        fs::write(folder.path().join("d.csv"), text).unwrap();
        Place(folder)
    }

    fn tmp(&self) -> PathBuf {
        self.0.path().join("tmp")
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.tmp()).unwrap().flatten();
        let mut names: Vec<String> =
            entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    fn started(&self) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
        command.current_dir(self.0.path()).env("TMPDIR", self.tmp());
        command.args(["eval", "--surface", "a", "--variant", "one", "--runner", "webgl2"]);
        command.args(["--directions", "d.csv"]).stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().unwrap()
    }

    /// Waits for the profile of a browser.
    fn profile(&self) -> PathBuf {
        let begun = Instant::now();
        loop {
            let is_profile = |name: &&String| {
                name.starts_with("diffraction-browser-")
                    && self.tmp().join(name).join("Default").exists()
            };
            if let Some(name) = self.names().iter().find(is_profile) {
                return self.tmp().join(name);
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "no browser: {:?}", self.names());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Number of processes with this folder in their command lines.
    fn running(&self) -> usize {
        let list = Command::new("ps").args(["-eo", "stat,args"]).output().unwrap();
        let text = String::from_utf8_lossy(&list.stdout).into_owned();
        let tmp = self.tmp().display().to_string();
        text.lines().filter(|line| line.contains(&tmp) && !line.starts_with('Z')).count()
    }

    fn waits_for_the_end(&self) {
        let begun = Instant::now();
        while self.running() > 0 {
            assert!(begun.elapsed() < Duration::from_secs(30), "a browser still runs");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

fn signal(name: &str, process: &str) {
    let _ = Command::new("sh").args(["-c", &format!("kill -{name} {process}")]).status();
}

/// Makes the lock of a profile look as if it had been left long ago.
fn age(profile: &Path) {
    let lock = File::options().append(true).open(profile.join("lock")).unwrap();
    lock.set_modified(SystemTime::UNIX_EPOCH).unwrap();
}

#[test]
fn a_command_in_a_browser_leaves_no_temporary_file() {
    if browser().is_none() {
        return;
    }
    let place = Place::new();
    assert!(place.started().wait().unwrap().success());
    assert_eq!(place.names(), Vec::<String>::new(), "after a run");
    for name in ["INT", "TERM"] {
        let mut child = place.started();
        place.profile();
        signal(name, &child.id().to_string());
        assert_eq!(child.wait().unwrap().code(), Some(130), "{name}");
        place.waits_for_the_end();
        assert_eq!(place.names(), Vec::<String>::new(), "after {name}");
    }
}

/// Killed without a chance to clean up: the next run does, and touches nothing that is not marked.
#[test]
fn a_profile_of_a_killed_run_goes_with_the_next_run() {
    if browser().is_none() {
        return;
    }
    let place = Place::new();
    let mut child = place.started();
    let profile = place.profile();
    // the child that is watched first, or it would clean up once its parent is gone
    let children =
        Command::new("ps").args(["-o", "pid=", "--ppid", &child.id().to_string()]).output();
    let children = String::from_utf8_lossy(&children.unwrap().stdout).into_owned();
    let all: Vec<&str> = children.split_whitespace().collect();
    signal("KILL", &format!("{} {}", all.join(" "), child.id()));
    child.wait().unwrap();
    place.waits_for_the_end();
    assert!(profile.exists(), "nobody was left to remove it");
    age(&profile);
    // planted beside it: a folder of that name without our mark, and a link of that name to a folder
    let tmp = place.tmp();
    fs::create_dir(tmp.join("diffraction-browser-planted")).unwrap();
    fs::write(tmp.join("diffraction-browser-planted/lock"), "mine").unwrap();
    let precious = place.0.path().join("precious");
    fs::create_dir(&precious).unwrap();
    fs::copy(profile.join("lock"), precious.join("lock")).unwrap();
    age(&precious);
    symlink(&precious, tmp.join("diffraction-browser-link")).unwrap();
    assert!(place.started().wait().unwrap().success());
    assert_eq!(place.names(), ["diffraction-browser-link", "diffraction-browser-planted"]);
    assert!(precious.join("lock").exists());
}
