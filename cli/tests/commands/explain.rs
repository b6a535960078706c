//! `explain` through the real command, on the committed plan.

use std::path::Path;
use std::process::{Command, Output};

fn explain(args: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction"));
    command.env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"));
    command.arg("explain").args(args).current_dir(root).output().unwrap()
}

#[test]
fn every_line_of_the_committed_text_has_its_place_in_a_template() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let shader = root.join("generated/shaders/cd/preview/diffraction.wgsl");
    let shader = std::fs::read_to_string(shader).unwrap();
    let done = explain(&["preview", "--surface", "cd"]);
    assert_eq!(done.status.code(), Some(0));
    let said = String::from_utf8(done.stdout).unwrap();
    assert_eq!(said.lines().count(), shader.lines().count());
    let (mut same, mut column) = (0, None);
    for (line, text) in said.lines().zip(shader.lines()) {
        let mut words = line.split_whitespace();
        let (place, number) = words.nth(1).unwrap().split_once(".wgsl:").unwrap();
        let template = std::fs::read_to_string(root.join(format!("{place}.wgsl"))).unwrap();
        let origin = template.lines().nth(number.parse::<usize>().unwrap() - 1).unwrap();
        assert!(line.ends_with(text), "{line}");
        if !text.is_empty() {
            assert_eq!(*column.get_or_insert(line.len() - text.len()), line.len() - text.len());
        }
        same += usize::from(origin.trim_end() == text);
    }
    // all but the header and the generated constants
    let declared = shader.lines().filter(|line| line.starts_with("const ")).count();
    assert_eq!(same + declared + 1, shader.lines().count());
}

#[test]
fn one_line_and_names_that_are_wrong() {
    let done = explain(&["preview", "--line", "2"]);
    let said = String::from_utf8(done.stdout).unwrap();
    assert!(
        said.starts_with("diffraction.wgsl:2       // ") && said.lines().count() == 2,
        "{said}"
    );
    for (args, part) in [
        (&["preview", "--line", "9999"][..], "diffraction.wgsl has"),
        (&["preview", "--surface", "cdd"][..], "did you mean \"cd\""),
        (&["previeww"][..], "did you mean \"preview\""),
    ] {
        let done = explain(args);
        assert_eq!((done.status.code(), done.stdout.len()), (Some(2), 0));
        let said = String::from_utf8(done.stderr).unwrap();
        // notes about the plan come first
        let error = said.lines().find(|line| !line.starts_with("note: ")).unwrap_or_default();
        assert!(error.starts_with("error: ") && said.contains(part), "{said}");
    }
}
