//! The committed plan and its committed package.
#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

use std::path::Path;
use std::process::{Command, Output};

fn xtask(args: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    Command::new(env!("CARGO_BIN_EXE_xtask")).args(args).current_dir(root).output().unwrap()
}

/// What it said, on both streams.
fn said(output: &Output) -> String {
    format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

#[test]
fn the_package_is_what_the_plan_gives() {
    let done = xtask(&["generate", "--check", "--no-cache"]);
    assert_eq!((done.status.code(), done.stdout.len()), (Some(0), 0), "{}", said(&done));
}

/// Every file of it by every validator that Debian packages; `tint` too where it is installed.
#[test]
fn validators_accept_all_of_it() {
    let required = std::env::var_os("DIFFRACTION_REQUIRE_TOOLS").is_some();
    let tools = if required {
        "naga,spirv-val,glslangValidator,hlsl-spirv-val,spirv-cross,reflection"
    } else {
        "naga"
    };
    let done = xtask(&["validate", "generated", "--require", tools]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
}

/// A broken file is found, and the exit code says so.
#[test]
fn validators_reject_a_spoiled_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let good = std::fs::read_to_string(
        root.join("generated/shaders/blazed/full-taylor-t19/diffraction.wgsl"),
    )
    .unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("diffraction.wgsl"),
        good.replace("textureLoad", "textureLode"),
    )
    .unwrap();
    let done = xtask(&["validate", folder.path().to_str().unwrap()]);
    assert_eq!(done.status.code(), Some(1), "{}", said(&done));
    assert!(said(&done).contains("textureLode"), "{}", said(&done));
}
