//! `cargo xtask validate` on the committed package, and what commands of the harness refuse.

use crate::support::tools;
use std::path::Path;
use std::process::{Command, Output};

fn harness(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
    command.args(args).current_dir(folder).output().unwrap()
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// What it said, on both streams.
fn said(output: &Output) -> String {
    format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

/// Every file of it by every validator that can be installed from a package; `tint` too where it is there.
#[test]
fn validators_accept_all_of_it() {
    let tools = if tools::are_required() {
        "naga,spirv-val,glslangValidator,hlsl-spirv-val,dxc,spirv-cross,reflection,metal-cpu"
    } else {
        "naga"
    };
    let done = harness(root(), &["validate", "generated", "--require", tools]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
}

/// A broken file is found, and the exit code says so.
#[test]
fn validators_reject_a_spoiled_file() {
    let good = std::fs::read_to_string(
        root().join("generated/shaders/blazed/full-taylor-t19/diffraction.wgsl"),
    )
    .unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("diffraction.wgsl"),
        good.replace("textureLoad", "textureLode"),
    )
    .unwrap();
    let done = harness(root(), &["validate", folder.path().to_str().unwrap()]);
    assert_eq!(done.status.code(), Some(1), "{}", said(&done));
    assert!(said(&done).contains("textureLode"), "{}", said(&done));
}

#[test]
fn what_is_not_there_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |args: &[&str], parts: &[&str]| {
        let done = harness(folder.path(), args);
        assert_eq!(done.status.code(), Some(2), "{args:?}: {}", said(&done));
        assert!(parts.iter().all(|part| said(&done).contains(part)), "{args:?}: {}", said(&done));
    };
    refused(&["validate", "absent"], &["absent"]);
    refused(&["serve", "--dir", "absent"], &["absent", "index.html", "serve --help"]);
    refused(&["validate", "--require", "nothing"], &["nothing", "naga"]);
}
