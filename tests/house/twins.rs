//! Every function of a mode's template has a twin of the same name, and the other way round.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Names after `fn ` at the start of a line's code, public or not, methods included.
fn functions(path: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(path).unwrap();
    let code = text.split("#[cfg(test)]").next().unwrap();
    let names = code.lines().filter_map(|line| {
        let line = line.trim_start().trim_start_matches("pub ");
        let name = line.strip_prefix("fn ")?;
        Some(name.split(['(', '<']).next().unwrap().to_owned())
    });
    names.collect()
}

/// Templates whose twin is that of another template: the same sum in another order.
const SHARED: [(&str, &str); 1] = [("thesis", "full")];
/// Templates without a file of that name among the twins: frames around the modes, and what all modes share.
const OTHERS: [&str; 6] = ["shader", "gain", "colour", "map", "probe", "surroundings"];

#[test]
fn templates_and_twins_have_the_same_functions() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut twins = BTreeSet::new();
    for entry in fs::read_dir(root.join("templates")).unwrap() {
        let template = entry.unwrap().path();
        let name = template.file_stem().unwrap().to_str().unwrap();
        if OTHERS.contains(&name) {
            continue;
        }
        let twin = SHARED.iter().find(|(shared, _)| *shared == name).map_or(name, |(_, twin)| twin);
        let path = format!("src/variant/twin/{twin}.rs");
        let functions_of_twin = functions(&root.join(&path));
        assert_eq!(functions(&template), functions_of_twin, "{name} against {path}");
        let text = fs::read_to_string(&template).unwrap();
        assert!(text.contains(&format!("//- Twin: {path}")), "{name}: no note of its twin");
        twins.insert(twin.to_owned());
    }
    let files = fs::read_dir(root.join("src/variant/twin")).unwrap();
    let files =
        files.map(|file| file.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned());
    assert_eq!(files.collect::<BTreeSet<_>>(), twins);
}

/// What every mode shares has its f64 form in `optics`.
#[test]
fn the_gain_is_in_optics() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shared = functions(&root.join("templates/gain.wgsl"));
    let of = |file| functions(&root.join("src/optics").join(file));
    let optics = &(&of("gain.rs") | &of("directions.rs")) | &of("matter.rs");
    assert!(!shared.is_empty() && shared.is_subset(&optics), "{shared:?} against {optics:?}");
}
