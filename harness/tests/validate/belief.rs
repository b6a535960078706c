//! Programs that only bear a validator's name. The PATH of each run begins with a folder that has one script.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// A folder with a program `tint`, and one with files to validate.
struct Scene {
    programs: TempDir,
    files: TempDir,
}

const GOOD: &str = "@fragment fn f() -> @location(0) vec4f { return vec4f(); }\n";

impl Scene {
    fn new(script: &str, mode: u32) -> Scene {
        let (programs, files) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let tint = programs.path().join("tint");
        fs::write(&tint, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&tint, fs::Permissions::from_mode(mode)).unwrap();
        fs::write(files.path().join("a.wgsl"), GOOD).unwrap();
        Scene { programs, files }
    }

    /// Runs the command; `path` follows the scene's folder on the PATH.
    fn validate(&self, path: &str, options: &[&str]) -> (Output, String) {
        let path = format!("{}:{path}", self.programs.path().display());
        let done = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"))
            .arg("validate")
            .arg(self.files.path())
            .args(options)
            .env("PATH", path)
            .output()
            .unwrap();
        let said = [&done.stdout[..], &done.stderr].concat();
        let said = String::from_utf8_lossy(&said).into_owned();
        (done, said)
    }
}

const SYSTEM: &str = "/usr/bin:/bin";

#[test]
fn a_program_that_accepts_everything_is_not_believed() {
    let scene = Scene::new("exit 0", 0o755);
    let (done, said) = scene.validate(SYSTEM, &[]);
    assert_eq!(done.status.code(), Some(0), "{said}");
    assert!(said.contains("not believed: it accepts a diffraction.wgsl of ours with"), "{said}");
    // naga alone has read the file
    let files = |tool: &str| {
        let line = said.lines().find(|line| line.starts_with(&format!("{tool} "))).unwrap();
        line.split_whitespace().nth(1).unwrap().to_owned()
    };
    assert_eq!((files("naga").as_str(), files("tint").as_str()), ("1", "0"), "{said}");
    let (done, said) = scene.validate(SYSTEM, &["--require", "tint"]);
    assert_eq!(done.status.code(), Some(2), "{said}");
    assert!(said.contains("tint: is required, but not believed"), "{said}");
}

#[test]
fn a_program_that_crashes_or_rejects_everything_is_not_believed() {
    for (script, why) in [("kill -SEGV $$", "signal: 11"), ("echo no; exit 3", "rejects a sound")] {
        let (done, said) = Scene::new(script, 0o755).validate(SYSTEM, &[]);
        assert_eq!(done.status.code(), Some(0), "{said}");
        assert!(said.contains("not believed") && said.contains(why), "{said}");
    }
}

#[test]
fn a_gigabyte_of_output_is_read_and_not_kept() {
    let script =
        "[ \"$1\" = --version ] && exit 0\nhead -c 1000000000 /dev/zero | tr '\\0' x; exit 1";
    let begun = Instant::now();
    let (done, said) = Scene::new(script, 0o755).validate(SYSTEM, &[]);
    assert_eq!(done.status.code(), Some(0), "{said}");
    assert!(said.contains("not believed: it rejects a sound diffraction.wgsl"), "{said}");
    assert!(said.len() < 10_000, "{}", said.len());
    assert!(begun.elapsed() < Duration::from_secs(50));
}

#[test]
fn a_file_that_nobody_may_execute_is_no_validator() {
    let scene = Scene::new("exit 1", 0o644);
    let (done, said) = scene.validate("", &[]);
    assert_eq!(done.status.code(), Some(0), "{said}");
    assert!(said.contains("not executable: ") && !said.contains("rejected by"), "{said}");
    let (done, said) = scene.validate("", &["--require", "tint"]);
    assert_eq!(done.status.code(), Some(2), "{said}");
    assert!(said.contains("is required, but not executable"), "{said}");
    // the system passes it over, too
    let other = Scene::new("exit 0", 0o755);
    let (_, said) = scene.validate(&other.programs.path().display().to_string(), &[]);
    assert!(said.contains("not believed"), "{said}");
}

/// It judges rightly, but for files whose name begins with `slow`.
const SLOW: &str = "for file; do :; done
case $file in
    --version) exit 0 ;;
    */slow*) sleep 314.159 ;;
    *) ! grep -q tristimulvs \"$file\" ;;
esac";

#[test]
fn a_program_that_does_not_answer_is_asked_no_more() {
    let scene = Scene::new(SLOW, 0o755);
    let (done, said) = scene.validate(SYSTEM, &[]);
    assert_eq!(done.status.code(), Some(0), "{said}");
    assert!(!said.contains("not believed") && !said.contains("not answering"), "{said}");
    for number in 0..8 {
        fs::write(scene.files.path().join(format!("slow{number}.wgsl")), GOOD).unwrap();
    }
    let begun = Instant::now();
    let (done, said) = scene.validate(SYSTEM, &["--time-limit", "1"]);
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.contains("did not end within 1 s; 8 files not checked"), "{said}");
    assert!(said.contains(" and 7 more: tint is not answering"), "{said}");
    // once for each thread, not once for each file
    let threads = std::thread::available_parallelism().unwrap().get() as u64;
    assert!(threads > 4 || begun.elapsed() < Duration::from_secs(7), "{:?}", begun.elapsed());
    gone("sleep 314.159");
}

/// No process has this command line: what a script has started is ended with it.
fn gone(command: &str) {
    let Ok(list) = Command::new("ps").args(["-eo", "args"]).output() else { return };
    let list = String::from_utf8_lossy(&list.stdout).into_owned();
    assert!(!list.lines().any(|line| line == command), "{list}");
}

#[test]
fn a_program_that_never_answers_is_a_finding() {
    let scene = Scene::new("sleep 300", 0o755);
    let (done, said) = scene.validate(SYSTEM, &["--time-limit", "0.5"]);
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.contains("tint: not answering: did not end within 0.5 s"), "{said}");
}
