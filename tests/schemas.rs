//! The schemas of all JSON files, against freshly generated ones.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::{fs, path::Path};

use diffraction_shaders::generate::{Request, generate};
use diffraction_shaders::manifest::SCHEMA_VERSION;
use diffraction_shaders::plan::{Plan, Target};
use diffraction_shaders::template::{GENERATED, Sources};
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
    assert_eq!(counts["probe"], 2);
}

/// A sum over lobes says what bounds its loops, the same number as in its text.
#[test]
fn bounds_of_lobes_are_those_of_the_text() {
    let text = "schema = 1\n[[surface]]\nname = \"blazed\"\ngrating = { kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 60 }\n[variants]\nmode = \"adaptive\"\nterms = 9\ncoherence = [\"single\", \"ensemble\"]\n[targets]\nemit = [\"wgsl\"]\n";
    let plan = Plan::parse(text, Path::new("plan.toml")).unwrap();
    let request = Request {
        surfaces: &plan.surfaces,
        variants: &plan.variants,
        targets: &plan.targets,
        containers: &plan.containers,
        sources: &Sources::builtin(),
        cache: None,
        keep: &|_, _| false,
    };
    let package = generate(&request, &|_| ()).unwrap_or_else(|e| panic!("{e:?}")).package;
    let schema = schema("variant");
    for (variant, limit) in
        [("adaptive-taylor-t9", json!(0.2)), ("adaptive-taylor-t9-ensemble", Value::Null)]
    {
        let folder = format!("shaders/blazed/{variant}");
        let bytes = package.bytes(&format!("{folder}/manifest.json")).unwrap();
        let manifest: Value = serde_json::from_slice(bytes).unwrap();
        assert_eq!(errors(&schema, &manifest), Vec::<String>::new(), "{variant}");
        let lobes = &manifest["lobes"];
        assert_eq!(lobes["overlap_limit"], limit);
        // ℓc = 65 µm on a patch of 2.5 µm: 2.5 · 4/(2π · 65)
        let overlap = 2.5 * 4.0 / (std::f64::consts::TAU * 65.0);
        assert!((lobes["overlap"].as_f64().unwrap() - overlap).abs() < 1e-12);
        let shader = package.bytes(&format!("{folder}/diffraction.wgsl")).unwrap();
        let shader = std::str::from_utf8(shader).unwrap();
        let bound = format!("const CANDIDATE_COUNT: i32 = {};", lobes["candidates"]);
        assert!(shader.contains(&bound), "{bound}");
        // a bin is sought once and counts at most twice
        assert!(shader.contains("hit < 2 * CANDIDATE_COUNT"));
        assert!(shader.contains("let candidates = select(0, CANDIDATE_COUNT, side == 0);"));
        let loops = shader.lines().filter(|line| line.contains("for (")).count();
        let bounded = ["< 2 * CANDIDATE_COUNT", "< candidates", "< LAYER_COUNT", ">= 0"];
        let known = |line: &&str| bounded.iter().any(|bound| line.contains(bound));
        let known = shader.lines().filter(|line| line.contains("for (")).filter(known).count();
        assert_eq!(loops, known);
        let mut wrong = manifest.clone();
        wrong["lobes"]["candidates"] = json!(0);
        assert_eq!(errors(&schema, &wrong).len(), 1);
    }
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

/// Probes are lit, unit vectors of 32 bits; a variant with enough terms is near the truth, within a hundredth.
#[test]
fn generated_probes_are_what_they_say() {
    let package = common::package();
    let path = format!("{}/probe.json", common::VARIANT_FOLDER);
    let probe: Value = serde_json::from_slice(package.bytes(&path).unwrap()).unwrap();
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let probes = probe["probes"].as_array().unwrap();
    let greatest = |of: &str| {
        let all = probes.iter().flat_map(|p| numbers(&p[of]["xyz"]));
        all.fold(0.0, f64::max)
    };
    for probe in probes {
        for direction in ["wi", "wr"] {
            let v = numbers(&probe[direction]);
            assert!((v.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 4e-7, "{v:?}");
            assert!(v.iter().all(|x| f64::from(*x as f32) == *x), "{v:?}");
        }
        let tolerance = probe["tolerance"].as_f64().unwrap();
        assert!(tolerance >= 2e-5 * greatest("expected"));
        assert!(numbers(&probe["exact"]["xyz"])[1] > 1e-4 * greatest("exact"), "{probe}");
    }
    assert!((greatest("expected") / greatest("exact") - 1.0).abs() < 0.1);
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
