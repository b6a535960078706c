//! An interrupt ends every command soon, with what it started, and leaves no temporary folder.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use diffraction_harness::drivers::gpu::{Backend, Gpu};
use tempfile::TempDir;

use crate::support::tools;

/// Far above the second that is promised, and far below what the commands would take.
const SOON: Duration = Duration::from_secs(8);

/// A deep relief: every command takes minutes on it.
const PLAN: &str = r#"schema = 1
[[surface]]
name = "deep"
grating = { kind = "fingers", size_um = 60.0, pixels = 640, pitch_um = 1.1, height_um = 9.0, seed = 1 }
[[preset]]
name = "one"
accept_error = true
terms = 150
"#;

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("plan.toml"), PLAN).unwrap();
    fs::create_dir(folder.path().join("tmp")).unwrap();
    let rows = "20,0,20,180\n".repeat(20_000);
    fs::write(folder.path().join("d.csv"), format!("theta_i,phi_i,theta_r,phi_r\n{rows}")).unwrap();
    folder
}

fn started(folder: &Path, line: &str, path: Option<&Path>) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
    command.current_dir(folder).args(line.split(' ')).env("TMPDIR", folder.join("tmp"));
    if let Some(path) = path {
        let old = std::env::var("PATH").unwrap_or_default();
        command.env("PATH", format!("{}:{old}", path.display()));
    }
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// Sends a signal and returns the exit code; fails if the process does not end.
fn ended(mut child: Child, signal: &str, line: &str) -> Option<i32> {
    let kill = format!("kill -{signal} {}", child.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success(), "{line}");
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        if begun.elapsed() > SOON {
            let _ = child.kill();
            panic!("{line}: still runs after {signal}");
        }
        sleep(Duration::from_millis(10));
    }
}

fn left(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder.join("tmp")).unwrap().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
}

#[test]
fn commands_in_the_middle_of_their_work_end_soon() {
    let has_driver = tools::found(Gpu::open(Backend::Vulkan, None)).is_some();
    let mut lines = vec![
        "eval --surface deep --directions d.csv",
        "render --surface deep --light 20,0 --size 2048 --out map.png",
        "testbench --surface deep --variant exact --wavelengths 380,780,0.25",
        "compare --route twin --size 256 --out out",
    ];
    if has_driver {
        lines.extend([
            "tune --surface deep --budget-de 1",
            "bench --backend vulkan --seconds 600 --baseline one",
            "scene --surface deep --variant one --out picture.png",
        ]);
    }
    for (round, line) in lines.into_iter().enumerate() {
        let folder = folder();
        let mut child = started(folder.path(), line, None);
        sleep(Duration::from_millis(1500));
        assert_eq!(child.try_wait().unwrap(), None, "{line}: ended by itself");
        let signal = if round % 2 == 0 { "INT" } else { "TERM" };
        assert_eq!(ended(child, signal, line), Some(130), "{line}");
        assert_eq!(left(folder.path()), Vec::<String>::new(), "{line}");
        assert!(
            !folder.path().join("map.png").exists() && !folder.path().join("picture.png").exists()
        );
    }
}

/// A validator that never answers ends with the command, with what it started.
#[test]
fn a_running_validator_ends_too() {
    let folder = folder();
    let tools = folder.path().join("bin");
    fs::create_dir(&tools).unwrap();
    let pids = folder.path().join("pids");
    let script = format!("#!/bin/sh\nsleep 1000 &\necho $$ $! >> '{}'\nwait\n", pids.display());
    for name in ["spirv-val", "glslangValidator", "spirv-cross", "g++", "tint"] {
        fs::write(tools.join(name), &script).unwrap();
        fs::set_permissions(tools.join(name), fs::Permissions::from_mode(0o755)).unwrap();
    }
    let line = "validate --time-limit 3600";
    fs::create_dir_all(folder.path().join("generated")).unwrap();
    let child = started(folder.path(), line, Some(&tools));
    let begun = Instant::now();
    while fs::read_to_string(&pids).unwrap_or_default().is_empty() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no validator was started");
        sleep(Duration::from_millis(20));
    }
    sleep(Duration::from_millis(200));
    assert_eq!(ended(child, "TERM", line), Some(130));
    let all = fs::read_to_string(&pids).unwrap();
    sleep(Duration::from_millis(100));
    for pid in all.split_whitespace() {
        let state = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        // an ended process that nobody has waited for yet
        let is_over = state.is_empty() || state.contains(") Z ");
        assert!(is_over, "{pid} still runs: {state}");
    }
    assert_eq!(left(folder.path()), Vec::<String>::new());
}

/// The watching process is gone at once; the work ends all the same.
#[test]
fn work_does_not_outlive_its_killed_parent() {
    if tools::found(Gpu::open(Backend::Vulkan, None)).is_none() {
        return;
    }
    let folder = folder();
    let mark = format!("deep-{}", std::process::id());
    let out = folder.path().join(&mark);
    let mut child = started(
        folder.path(),
        &format!("compare --route twin --size 256 --out {}", out.display()),
        None,
    );
    sleep(Duration::from_millis(1500));
    let running = || {
        let list = Command::new("ps").args(["-eo", "pid,stat,args"]).output().unwrap();
        let text = String::from_utf8_lossy(&list.stdout).into_owned();
        text.lines().filter(|l| l.contains(&mark) && !l.contains(" Z")).count()
    };
    assert!(running() >= 2, "a parent and its child");
    child.kill().unwrap();
    child.wait().unwrap();
    let begun = Instant::now();
    while running() > 0 {
        assert!(begun.elapsed() < SOON, "the child still runs");
        sleep(Duration::from_millis(20));
    }
}
