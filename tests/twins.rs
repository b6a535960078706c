//! Every function of a mode's template has a twin of the same name, and the other way round.
#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Names after `fn ` at the start of a line's code, public or not, methods included.
fn functions(path: &Path, except: &[&str]) -> BTreeSet<String> {
    let text = fs::read_to_string(path).unwrap();
    let code = text.split("#[cfg(test)]").next().unwrap();
    let names = code.lines().filter_map(|line| {
        let line = line.trim_start().trim_start_matches("pub ");
        let name = line.strip_prefix("fn ")?;
        Some(name.split(['(', '<']).next().unwrap().to_owned())
    });
    names.filter(|name| !except.contains(&name.as_str())).collect()
}

#[test]
fn templates_and_twins_have_the_same_functions() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut modes = 0;
    for entry in fs::read_dir(root.join("src/variant/twin")).unwrap() {
        let twin = entry.unwrap().path();
        let name = twin.file_stem().unwrap().to_str().unwrap();
        let template = root.join(format!("templates/{name}.wgsl"));
        assert_eq!(functions(&template, &[]), functions(&twin, &["optics"]), "{name}");
        modes += 1;
    }
    assert!(modes > 0);
}

/// What every mode shares has its f64 form in `optics`.
#[test]
fn the_gain_is_in_optics() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shared = functions(&root.join("templates/gain.wgsl"), &[]);
    let optics = functions(&root.join("src/optics.rs"), &[]);
    assert!(!shared.is_empty() && shared.is_subset(&optics), "{shared:?} against {optics:?}");
}
