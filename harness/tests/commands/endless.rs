//! Records, baselines and meshes that are pipes, devices or without end are refused at once.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const PLAN: &str = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 40 }
[[preset]]
name = "one"
terms = 12
"#;

/// Exit code and stderr. A command that hangs fails.
fn said(folder: &Path, line: &str) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
    command.args(line.split(' ')).current_dir(folder);
    let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > Duration::from_secs(60) {
            let _ = child.kill();
            panic!("{line}: hangs");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let done = child.wait_with_output().unwrap();
    (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
}

#[test]
fn records_baselines_and_meshes_are_regular_files() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    fs::write(folder.join("plan.toml"), PLAN).unwrap();
    let made = Command::new("mkfifo").arg(folder.join("pipe")).status().unwrap();
    assert!(made.success());
    symlink("/dev/zero", folder.join("zero")).unwrap();
    fs::File::create(folder.join("huge")).unwrap().set_len(1 << 40).unwrap();
    for name in ["pipe", "zero", "huge"] {
        let out = format!("run-{name}");
        fs::create_dir(folder.join(&out)).unwrap();
        symlink(folder.join(name), folder.join(&out).join("records.jsonl")).unwrap();
        symlink(folder.join(name), folder.join(&out).join("before.jsonl")).unwrap();
        for extension in ["gltf", "obj"] {
            symlink(folder.join(name), folder.join(format!("{name}.{extension}"))).unwrap();
        }
        for line in [
            format!("report {out}"),
            format!("compare --route twin --size 8 --out {out}"),
            format!("compare --route twin --size 8 --resume --out {out}"),
            format!("bench --out {out} --compare-to before --seconds 0"),
            format!("testbench --surface a --variant exact --out {out}"),
            format!("scene --surface a --out p.png --mesh {name}.gltf"),
            format!("scene --surface a --out p.png --mesh {name}.obj"),
        ] {
            let (code, text) = said(folder, &line);
            assert_eq!(code, Some(2), "{line}: {text}");
            let is_named = text.contains(&out) || text.contains(name);
            assert!(is_named, "{line}: {text}");
        }
    }
    // the control
    let (code, text) = said(folder, "compare --route twin --size 8 --out fine");
    assert_eq!(code, Some(0), "{text}");
    assert_eq!(said(folder, "report fine").0, Some(0));
}

/// A picture that is a link out of the folder does not get into the page; one inside does.
#[test]
fn a_report_takes_no_picture_from_outside_its_folder() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    let record = |picture: &str| {
        format!(
            "{{\"kind\":\"testbench\",\"surface\":\"a\",\"variant\":\"exact\",\"route\":\"exact\",\"theta_i\":75,\"phi_i\":0,\"expected_nm\":2500,\
             \"period_nm\":2500.1,\"sd_nm\":0.1,\"points\":81,\"evanescent\":0,\"flat\":0,\"closed_nm\":null,\"window\":null,\"windows\":null,\
             \"weight\":1,\"svg\":\"{picture}\"}}\n"
        )
    };
    let run = folder.join("run");
    fs::create_dir(&run).unwrap();
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\"><desc>marked</desc></svg>";
    fs::write(folder.join("outside.svg"), svg).unwrap();
    fs::write(run.join("inside.svg"), svg).unwrap();
    symlink(folder.join("outside.svg"), run.join("link.svg")).unwrap();
    let page = |picture: &str| {
        fs::write(run.join("records.jsonl"), record(picture)).unwrap();
        let (code, text) = said(folder, "report run");
        assert_eq!(code, Some(0), "{text}");
        (text, fs::read(run.join("report.html")).unwrap())
    };
    let (text, with) = page("inside.svg");
    assert!(!text.contains("picture missing"), "{text}");
    let (text, without) = page("link.svg");
    assert!(text.contains("leads out of the folder through a link"), "{text}");
    assert!(with.len() > without.len());
}
