//! The schemas of all JSON files, against freshly generated ones.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::{fs, path::Path};

use diffraction_shaders::{manifest::SCHEMA_VERSION, plan::Target, template::GENERATED};
use jsonschema::Validator;
use serde_json::{Value, json};

fn schema(name: &str) -> Validator {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("schemas/{name}.schema.json"));
    let schema: Value = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    assert!(jsonschema::meta::is_valid(&schema), "{name}");
    jsonschema::validator_for(&schema).unwrap()
}

/// Which schema a file of a package has to keep.
fn schema_of(path: &str) -> Option<&'static str> {
    match path {
        "manifest.json" => Some("package"),
        _ if path.ends_with("/manifest.json") => Some("variant"),
        _ if path.ends_with("/probe.json") => Some("probe"),
        _ if path.ends_with(".json") => Some("table"),
        _ => None,
    }
}

/// All that a schema has against a value.
fn errors(schema: &Validator, value: &Value) -> Vec<String> {
    let describe =
        |error: jsonschema::ValidationError| format!("{}: {error}", error.instance_path());
    schema.iter_errors(value).map(describe).collect()
}

#[test]
fn generated_files_keep_their_schemas() {
    let package = common::package();
    let mut counts = std::collections::BTreeMap::new();
    for path in package.files().keys() {
        let Some(name) = schema_of(path) else { continue };
        let value = serde_json::from_slice(package.bytes(path).unwrap()).unwrap();
        assert_eq!(errors(&schema(name), &value), Vec::<String>::new(), "{path}");
        *counts.entry(name).or_insert(0) += 1;
    }
    assert!(counts["package"] == 1 && counts["variant"] == 2 && counts["table"] >= 3, "{counts:?}");
}

#[test]
fn schemas_refuse_what_is_missing_wrong_or_too_much() {
    let package = common::package();
    let read =
        |path: &str| -> Value { serde_json::from_slice(package.bytes(path).unwrap()).unwrap() };
    let table =
        package.files().keys().find(|path| path.contains("/terms-") && path.ends_with(".json"));
    let variant = format!("{}/manifest.json", common::VARIANT_FOLDER);
    for (path, pointer, wrong) in [
        ("manifest.json", "/schema_version", json!(SCHEMA_VERSION + 1)),
        ("manifest.json", "/targets/0", json!("dxil")),
        ("manifest.json", "/surfaces/tiny/input_hash", json!("none")),
        (variant.as_str(), "/uniforms/0/members/1/offset", json!(20)),
        (variant.as_str(), "/core/clamped", json!(true)),
        (variant.as_str(), "/bindings/0/kind", json!("buffer")),
        (variant.as_str(), "/targets/wgsl/0/entry_points/0/stage", json!("compute")),
        (table.unwrap(), "/endianness", json!("big")),
        (table.unwrap(), "/width", json!(0)),
    ] {
        let schema = schema(schema_of(path).unwrap());
        let mut value = read(path);
        *value.pointer_mut(pointer).unwrap_or_else(|| panic!("{path} has no {pointer}")) = wrong;
        assert_eq!(errors(&schema, &value).len(), 1, "{path} {pointer}");
        let mut value = read(path);
        value["more"] = json!(1);
        assert!(!schema.is_valid(&value), "{path}");
        for key in read(path).as_object().unwrap().keys() {
            let mut value = read(path);
            value.as_object_mut().unwrap().remove(key);
            assert!(!schema.is_valid(&value), "{path} without {key}");
        }
    }
}

#[test]
fn probes() {
    let probe = json!({
        "wi": [0.0, 0.0, 1.0],
        "wr": [0.6, 0.0, 0.8],
        "exact": { "xyz": [0.1, 0.2, 0.3] },
        "expected": { "xyz": [0.1, 0.2, 0.3], "rgb": [-0.1, 0.2, 0.3] },
        "tolerance": 1e-5,
    });
    let file = |probes: Vec<Value>| {
        json!({
            "generated_by": GENERATED,
            "schema_version": SCHEMA_VERSION,
            "surface": "tiny",
            "variant": "full-taylor-t3",
            "probes": probes,
        })
    };
    let schema = schema("probe");
    assert_eq!(errors(&schema, &file(vec![probe.clone(); 64])), Vec::<String>::new());
    assert!(!schema.is_valid(&file(vec![probe.clone(); 63])));
    for (pointer, wrong) in [
        ("/wi", json!([0.0, 1.0])),
        ("/wr/0", json!(7.0)),
        ("/exact", json!({})),
        ("/expected/rgb/0", json!(null)),
        ("/tolerance", json!(0.0)),
    ] {
        let mut probes = vec![probe.clone(); 64];
        *probes[5].pointer_mut(pointer).unwrap() = wrong;
        assert!(!schema.is_valid(&file(probes)), "{pointer}");
    }
}

#[test]
fn schemas_name_every_target() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas/package.schema.json");
    let schema: Value = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    let words: Vec<&str> = Target::all().into_iter().map(Target::as_str).collect();
    assert_eq!(schema["properties"]["targets"]["items"]["enum"], json!(words));
}
