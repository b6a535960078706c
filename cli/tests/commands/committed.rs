//! The committed plan and its committed package.

use std::path::Path;
use std::process::{Command, Output};

fn diffraction(args: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    Command::new(env!("CARGO_BIN_EXE_diffraction"))
        .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .args(args)
        .current_dir(root)
        .output()
        .unwrap()
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
    let done = diffraction(&["generate", "--check", "--no-cache"]);
    assert_eq!((done.status.code(), done.stdout.len()), (Some(0), 0), "{}", said(&done));
}
