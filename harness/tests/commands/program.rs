//! The harness's program, by hand and in the place of another.

use std::process::{Command, Output};

fn run(called_as: Option<&str>, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
    command.args(args).env_remove("DIFFRACTION_CALLED_AS");
    command.envs(called_as.map(|name| ("DIFFRACTION_CALLED_AS", name))).output().unwrap()
}

#[test]
fn help_and_errors_name_the_program_that_was_called() {
    for name in [None, Some("diffraction"), Some("cargo xtask")] {
        let called = name.unwrap_or("diffraction-harness");
        for command in
            ["import", "validate", "eval", "render", "compare", "testbench", "bench", "tune"]
        {
            let help = run(name, &[command, "--help"]);
            let help = String::from_utf8_lossy(&help.stdout);
            assert!(help.contains(&format!("Usage: {called} {command} ")), "{help}");
            assert!(help.contains(&format!("\n  {called} {command}")), "{help}");
            assert!(called == "cargo xtask" || !help.contains("xtask"), "{help}");
        }
        let refused = run(name, &["serve", "--dir", "absent"]);
        assert_eq!((refused.status.code(), refused.stdout.len()), (Some(2), 0));
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(said.contains(&format!("; {called} serve --help")), "{said}");
    }
}

/// By its last word another program knows whether the two belong together.
#[test]
fn it_says_its_version() {
    let version = String::from_utf8(run(None, &["--version"]).stdout).unwrap();
    assert_eq!(version, concat!("diffraction-harness ", env!("CARGO_PKG_VERSION"), "\n"));
}
