//! Manifests against spirv-cross, on a small package.

use crate::support::package;
use crate::support::tools;
use std::{fs, path::Path};

use diffraction_harness::validate::{Reflection, TIME_LIMIT, Tool};

/// What the tool says about one of the package's files, with its manifest edited.
fn check(file: &str, edit: impl Fn(&str) -> String) -> Option<Result<Option<f64>, String>> {
    let tool = Reflection::new(TIME_LIMIT);
    if tool.version().is_err() {
        tools::missing("spirv-cross is not installed");
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let package = package::package();
    for name in [file, "manifest.json"] {
        let bytes = package.bytes(&format!("{}/{name}", package::VARIANT_FOLDER)).unwrap();
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    let manifest = folder.path().join("manifest.json");
    let text = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, edit(&text)).unwrap();
    Some(tool.check(&folder.path().join(Path::new(file))).map_err(|fault| fault.to_string()))
}

#[test]
fn manifests_agree_with_an_independent_reflection() {
    let entries = ["vert", "frag", "probe.frag", "mesh.vert", "mesh.frag"];
    for file in entries.map(|entry| format!("diffraction.{entry}.spv")) {
        let file = file.as_str();
        assert!(matches!(check(file, str::to_owned), None | Some(Ok(None))), "{file}");
    }
}

#[test]
fn a_wrong_manifest_is_caught() {
    for (right, wrong, expected) in [
        ("\"offset\": 16", "\"offset\": 32", "params.size vec4f at 32"),
        ("\"size\": 32", "\"size\": 48", "params 48 bytes"),
        ("\"binding\": 1,", "\"binding\": 2,", "terms 0.2"),
        ("\"emitted_binding\": 1", "\"emitted_binding\": 5", "terms 0.5 as emitted"),
        ("\"group\": 0", "\"group\": 1", "1."),
        ("\"2d-array\"", "\"2d\"", "terms 0.1 texture 2d"),
        ("\"emitted_name\": \"terms\"", "\"emitted_name\": \"terns\"", "terns"),
        ("\"emitted_name\": \"map\"", "\"emitted_name\": \"main\"", "main fragment"),
        ("\"name\": \"light\"", "\"name\": \"lamp\"", "params.lamp"),
        ("diffraction.frag.spv", "other.frag.spv", "lists no SPIR-V file"),
    ] {
        let edit = |text: &str| {
            assert!(text.contains(right), "{right}");
            text.replace(right, wrong)
        };
        let Some(checked) = check("diffraction.frag.spv", edit) else { return };
        let said = checked.expect_err(wrong);
        assert!(said.contains(expected), "{wrong}: {said}");
    }
    let Some(checked) = check("diffraction.frag.spv", |_| "{}".to_owned()) else { return };
    assert!(checked.is_err());
}
