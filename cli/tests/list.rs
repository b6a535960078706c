//! `diffraction list` as a user runs it: data on stdout, diagnostics on stderr, exit codes.
#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const PLAN: &str = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 100 }
[variants]
mode = ["full", "pq"]
coherence_scaling = "wavelength"
[[preset]]
name = "as-printed"
basis = "taylor-zero"
packing = "single"
hoist = false
"#;

fn diffraction(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_diffraction"))
        .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .args(args)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn folder(plan: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    folder
}

#[test]
fn json_has_everything_in_the_order_of_the_plan() {
    let done = diffraction(folder(PLAN).path(), &["list", "--json"]);
    assert_eq!((done.status.code(), done.stderr.len()), (Some(0), 0));
    let list: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(list["surfaces"][0]["name"], "a");
    assert_eq!(list["variants"][0]["name"], "full-taylor-t31-lcwave");
    assert_eq!(list["variants"][0]["mode"], "full");
    assert_eq!(list["variants"][0]["cost"][0]["term_fetches"], 81 * 16 * 9);
    assert_eq!(list["variants"][1]["name"], "as-printed");
    assert_eq!(list["variants"][1]["cost"][0]["term_fetches"], 22_599);
    assert_eq!(list["variants"][1]["cost"][0]["fetches"], 22_599 + 81);
    assert_eq!(
        list["targets"],
        serde_json::json!(["wgsl", "glsl450", "glsl-es300", "spirv", "hlsl", "msl"])
    );
    assert_eq!(list["rejected"][0]["name"], "pq-taylor-t31-lcwave");
    let reason = "pq repeats the patch a whole number of times, the same for all wavelengths";
    assert_eq!(list["rejected"][0]["reason"], reason);
}

#[test]
fn the_table_tells_costs_and_rejections() {
    let done = diffraction(folder(PLAN).path(), &["list"]);
    let text = String::from_utf8(done.stdout).unwrap();
    for part in [
        "blazed, 2.5 µm",
        "as-printed",
        "22599",
        "pq-taylor-t31-lcwave",
        "a whole number of times",
        "targets: wgsl",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

#[test]
fn every_fault_of_a_plan_is_one_line_and_the_exit_code_is_two() {
    let broken = PLAN.replace("0.3", "-1").replace("\"full\", \"pq\"", "\"fool\"");
    let folder = folder(&broken);
    let done = diffraction(folder.path(), &["list"]);
    let told = String::from_utf8(done.stderr).unwrap();
    assert_eq!((done.status.code(), done.stdout.len()), (Some(2), 0));
    assert_eq!(told.lines().count(), 2, "{told}");
    assert!(
        told.starts_with("error: plan.toml:4: surface.a.grating.height_um = -1: must be positive"),
        "{told}"
    );
    let done = diffraction(folder.path(), &["--message-format", "json", "list"]);
    for line in String::from_utf8(done.stderr).unwrap().lines() {
        let object: serde_json::Value = serde_json::from_str(line).unwrap();
        assert_eq!(object["severity"], "error", "{line}");
    }
    assert_eq!(
        diffraction(folder.path(), &["list", "--plan", "absent.toml"]).status.code(),
        Some(2)
    );
    assert_eq!(diffraction(folder.path(), &["list", "--jsn"]).status.code(), Some(2));
    assert_eq!(diffraction(folder.path(), &[]).status.code(), Some(2));
}

#[test]
fn the_committed_plan_is_sound() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let done = diffraction(root, &["list", "--json"]);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let list: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(list["rejected"].as_array().map(Vec::len), Some(0));
}
