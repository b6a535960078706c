//! `cargo xtask` and the harness: built when it is missing or old, then called with the same arguments.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// Says its arguments, one on a line, and how it was called.
const HARNESS: &str = "#!/bin/sh
printf '<%s>\\n' \"$@\"
echo \"$DIFFRACTION_CALLED_AS\"
exit 1
";

/// Says on stderr how it was called, and makes no program.
const CARGO: &str = "#!/bin/sh
echo \"cargo $*\" >&2
";

/// A target folder of its own with this program.
struct Target(tempfile::TempDir);

impl Target {
    fn new() -> Target {
        let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
        fs::create_dir(folder.path().join("release")).unwrap();
        fs::hard_link(env!("CARGO_BIN_EXE_xtask"), folder.path().join("release/xtask")).unwrap();
        Target(folder)
    }

    /// Writes a program.
    fn program(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join("release").join(name);
        // a file that this process held open could not be started while another thread starts something
        let script = "printf %s \"$1\" > \"$2\" && chmod +x \"$2\"";
        let mut command = Command::new("sh");
        assert!(command.args(["-c", script, "sh", text]).arg(&path).status().unwrap().success());
        path
    }

    fn run(&self, args: &[&str]) -> Output {
        let cargo = self.program("cargo", CARGO);
        let mut command = Command::new(self.0.path().join("release/xtask"));
        command.args(args).env("CARGO", cargo).current_dir(self.0.path()).output().unwrap()
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn the_harness_gets_the_arguments_as_they_are_and_its_exit_code_counts() {
    let target = Target::new();
    target.program("diffraction-harness", HARNESS);
    let long = ["--message-format=json", "bench", "--surface", "a b", "", "--help", "--", "*"];
    for args in [&long[..], &["eval", "--surface", "a", "--runner", "gl", "--directions", "b"]] {
        let done = target.run(args);
        let wanted: String = args.iter().map(|arg| format!("<{arg}>\n")).collect();
        assert_eq!((done.status.code(), text(&done.stdout)), (Some(1), wanted + "cargo xtask\n"));
        assert_eq!(text(&done.stderr), "", "nothing is built that is there");
    }
}

#[test]
fn a_missing_or_old_harness_is_built_after_one_line_that_says_so() {
    let target = Target::new();
    let missing = target.run(&["compare"]);
    let harness = target.program("diffraction-harness", HARNESS);
    let old = fs::File::options().append(true).open(harness).unwrap();
    old.set_modified(std::time::UNIX_EPOCH).unwrap();
    drop(old);
    fs::remove_file(target.0.path().join("release/.diffraction-harness-looked-at")).unwrap();
    let old = target.run(&["compare"]);
    for said in [text(&missing.stderr), text(&old.stderr)] {
        let lines: Vec<&str> = said.lines().collect();
        assert!(lines[0].starts_with("note: building diffraction-harness: "), "{said}");
        let folder = target.0.path().display();
        let call = format!("build --release -p diffraction-harness --target-dir {folder}");
        assert_eq!(lines[1], format!("cargo {call}"), "{said}");
    }
    assert_eq!(missing.status.code(), Some(2), "the cargo of this test builds nothing");
    assert_eq!(
        (old.status.code(), text(&old.stdout)),
        (Some(1), "<compare>\ncargo xtask\n".into())
    );
    // it was looked at since its sources changed
    assert_eq!(text(&target.run(&["compare"]).stderr), "");
}

#[test]
fn help_lists_all_commands_in_their_order() {
    let help = text(&Target::new().run(&["--help"]).stdout);
    let names = "generate list import material inspect validate explain eval render studio pattern compare testbench \
                 bench tune scene report serve test help";
    let places: Vec<Option<usize>> =
        names.split_whitespace().map(|name| help.find(&format!("\n  {name} "))).collect();
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{help}");
    assert!(help.contains("Usage: cargo xtask "), "{help}");
}
