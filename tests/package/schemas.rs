//! The schemas of all JSON files, against freshly generated ones.

use crate::support::package;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;
use std::{fs, path::Path};

use crate::support::schemas::{is_of_type, places, walk};
use diffraction_shaders::Compiler;
use diffraction_shaders::input::read_plan;
use diffraction_shaders::package::Package;
use diffraction_shaders::package::manifest::SCHEMA_VERSION;
use diffraction_shaders::plan::{Plan, Target, vocabulary};
use diffraction_shaders::shader::limits::Profile;
use diffraction_shaders::shader::template::GENERATED;
use diffraction_shaders::variant::CENTRED;
use jsonschema::Validator;
use serde_json::{Value, json};

const SCHEMAS: [&str; 4] = ["package", "variant", "table", "probe"];

fn schema_text(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("schemas/{name}.schema.json"));
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn schema(name: &str) -> Validator {
    let schema = schema_text(name);
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

/// Every form that a package may have, on small surfaces: flat, along the axes, turned. `gems` has no period on the flat one.
const FORMS: &str = r#"schema = 1
[[surface]]
name = "tiny"
grating = { kind = "blazed", period_um = 1.0, height_um = 0.015, pixels = 16 }
[[surface]]
name = "turned"
grating = { kind = "lamellar", period_um = 1.0, height_um = 0.015, pixels = 16, duty = 0.5 }
rotate_deg = 30.0
[[surface]]
name = "flat"
grating = { kind = "flat", period_um = 1.0, pixels = 16 }
[variants]
mode = "full"
basis = ["taylor", "taylor-zero", "chebyshev", "optimal"]
terms = 3
window_radius = 0
wavelengths = { min_nm = 400, max_nm = 700, step_nm = 100 }
table = ["f32", "f16"]
packing = ["paired", "single"]
bake_error = 10.0
bake_mib = 0.25
[[preset]]
name = "as-printed"
basis = "taylor-zero"
terms = 2
packing = "single"
hoist = false
[[preset]]
name = "left-to-the-tool"
terms = "auto"
window_radius = "auto"
colour = "thesis"
illuminant = "A"
[[preset]]
name = "on-one-surface"
surfaces = ["turned"]
terms = 2
[[preset]]
name = "one-wavelength"
wavelengths = { min_nm = 550, max_nm = 550 }
terms = 2
[[preset]]
name = "ensemble"
coherence = "ensemble"
coherence_scaling = "wavelength"
shadowing = false
terms = 2
[[preset]]
name = "prefiltered"
basis = "chebyshev"
reconstruction = "prefiltered"
coherence_um = 2.0
terms = 3
[[preset]]
name = "prefiltered-filter"
reconstruction = "prefiltered"
sampling = "filter"
table = "f16"
coherence_um = 2.0
terms = 3
[[preset]]
name = "pq"
mode = "pq"
terms = 3
[[preset]]
name = "pq-given"
mode = "pq"
periods = [3, 4]
table = "f16"
terms = 3
[[preset]]
name = "orders"
mode = "orders"
lights = ["direction", "disc", "polygon", "environment", "path"]
nodes = "auto"
source_diameter_deg = 0.53
[[preset]]
name = "foil"
mode = "orders"
lights = ["direction", "disc", "polygon", "environment", "path"]
source_diameter_deg = 0.53
pattern = true
period_ratio = [0.6, 1.6]
depth_ratio = [0.5, 1.5]
[[preset]]
name = "metal"
mode = "orders"
source_diameter_deg = 0.53
material = { nk = "metal.csv" }
cover_index = { nk = "cover.csv" }
films = [{ index = 2.2, thickness_nm = 60 }, { index = { nk = "metal.csv" }, thickness_nm = 5 }]
obliquity = "unpolarised"
[[preset]]
name = "named-films"
mode = "adaptive"
terms = 7
material = "gold"
cover_index = 1.5
films = [{ index = "silver", thickness_nm = 5 }]
obliquity = "te"
[[preset]]
name = "orders-direction"
mode = "orders"
lights = ["direction"]
[[preset]]
name = "adaptive"
mode = "adaptive"
terms = 3
[[preset]]
name = "adaptive-ensemble"
mode = "adaptive"
coherence = "ensemble"
basis = "optimal"
table = "f16"
terms = 3
[[preset]]
name = "adaptive-prefiltered"
mode = "adaptive"
reconstruction = "prefiltered"
coherence_um = 2.0
terms = 3
[[preset]]
name = "adaptive-filter"
mode = "adaptive"
reconstruction = "prefiltered"
sampling = "filter"
basis = "optimal"
table = "f16"
packing = "single"
coherence_um = 2.0
terms = 3
[[preset]]
name = "soft"
mode = "baked"
table = "f16"
sampling = "filter"
bake_error = 10.0
bake_mib = 0.25
coherence = "ensemble"
source_diameter_deg = 6
spread_levels = 3
spread_step = 1.5
cells = 32
[[preset]]
name = "softest"
mode = "baked"
bake_error = 10.0
bake_mib = 0.25
coherence = "ensemble"
source_diameter_deg = 8
spread_levels = "auto"
lights = ["direction"]
[[preset]]
name = "traced"
mode = "baked"
bake_error = 10.0
bake_mib = 0.25
coherence = "ensemble"
source_diameter_deg = 8
lights = ["direction", "path"]
[[preset]]
name = "gems"
mode = "gems"
BAKED[targets]
tables = ["bin", "ktx2", "exr"]
"#;

/// The forms of `baked`: formats that a filter reads, and those that are loaded.
fn forms() -> String {
    let baked = [
        ("f32", "load"),
        ("f16", "load"),
        ("f16", "filter"),
        ("rgb9e5", "load"),
        ("rgb9e5", "filter"),
    ];
    let preset = |(table, sampling): (&str, &str)| {
        format!(
            r#"[[preset]]
name = "baked-{table}-{sampling}"
mode = "baked"
table = "{table}"
sampling = "{sampling}"
bake_error = 10.0
bake_mib = 0.25
"#
        )
    };
    let metals = ["aluminium", "silver", "gold", "copper", "nickel", "chromium", "dielectric"];
    let metal = |(i, metal): (usize, &str)| {
        format!(
            r#"[[preset]]
name = "{metal}"
mode = "orders"
lights = ["direction"]
material = "{metal}"
refractive_index = 2.4
cover_index = "{}"
obliquity = "{}"
"#,
            ["polycarbonate", "pmma"][i % 2],
            ["te", "tm", "unpolarised", "stam"][i % 4]
        )
    };
    let metals: String = metals.into_iter().enumerate().map(metal).collect();
    FORMS.replace("BAKED", &(baked.map(preset).concat() + &metals))
}

/// A surface whose table is wider than any API guarantees, so that every profile has its gap.
const WIDE: &str = r#"schema = 1
[[surface]]
name = "wide"
grating = { kind = "blazed", period_um = 800.0, height_um = 0.1, pixels = 9000 }
[variants]
terms = 1
window_radius = 0
wavelengths = { min_nm = 380, max_nm = 780, step_nm = 200 }
accept_error = true
[targets]
emit = "wgsl"
"#;

struct Made {
    plan: Plan,
    package: Package,
}

fn made(text: &str) -> Made {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("metal.csv"), "wavelength_nm,n,k\n380,1,3\n780,2,5\n").unwrap();
    fs::write(folder.path().join("cover.csv"), "wavelength_nm,n,k\n380,1.6,0\n780,1.5,0\n")
        .unwrap();
    fs::write(folder.path().join("plan.toml"), text).unwrap();
    let plan = read_plan(&folder.path().join("plan.toml")).unwrap_or_else(|e| panic!("{e:?}"));
    let package = Compiler::new(&plan).compile().unwrap_or_else(|e| panic!("{e}"));
    Made { plan, package }
}

/// The packages that between them have everything, made once.
fn packages() -> &'static [Made] {
    static PACKAGES: OnceLock<[Made; 2]> = OnceLock::new();
    PACKAGES.get_or_init(|| [made(&forms()), made(WIDE)])
}

/// All JSON files of all packages with the names of their schemas.
fn documents() -> Vec<(&'static str, String, Value)> {
    let of = |made: &'static Made| {
        made.package.files().keys().filter_map(|path| {
            let value = serde_json::from_slice(made.package.bytes(path).unwrap());
            Some((schema_of(path)?, path.clone(), value.unwrap()))
        })
    };
    packages().iter().flat_map(of).collect()
}

#[test]
fn files_of_every_form_keep_their_schemas() {
    let schemas: BTreeMap<&str, Validator> = SCHEMAS.map(|name| (name, schema(name))).into();
    let mut wrong = Vec::new();
    for (name, path, value) in documents() {
        wrong.extend(errors(&schemas[name], &value).into_iter().map(|e| format!("{path}: {e}")));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The packages that schemas are tested with have every word of a variant's keys, and the gaps that are meant.
#[test]
fn the_forms_are_all_forms() {
    let Made { plan, package } = &packages()[0];
    let mut built = BTreeSet::new();
    for variant in &plan.variants {
        let path = format!("shaders/turned/{}/manifest.json", variant.name);
        let file = package.bytes(&path).unwrap_or_else(|| panic!("{path}"));
        let manifest: Value = serde_json::from_slice(file).unwrap();
        for (key, value) in manifest["configuration"].as_object().unwrap() {
            built.insert((key.clone(), value.as_str().map(str::to_owned)));
            let words = value.as_array().into_iter().flatten();
            built.extend(words.map(|word| (key.clone(), word.as_str().map(str::to_owned))));
        }
    }
    for key in vocabulary().into_iter().filter(|key| key.table == "variants") {
        // a window is what is summed unless another form is named
        for word in key.words.into_iter().filter(|word| word != "window") {
            assert!(
                built.contains(&(key.name.clone(), Some(word.clone()))),
                "no {} {word}",
                key.name
            );
        }
    }
    let index: Value = serde_json::from_slice(package.bytes("manifest.json").unwrap()).unwrap();
    let gaps: Vec<&str> = index["gaps"]
        .as_array()
        .unwrap()
        .iter()
        .map(|gap| gap["variant"].as_str().unwrap())
        .collect();
    assert!(gaps.contains(&"gems"), "{gaps:?}");
    assert!(
        index["gaps"].as_array().unwrap().iter().all(|gap| gap["surface"] == "flat"),
        "{gaps:?}"
    );
}

/// No schema leaves room: every object is closed or a map of what it states, every value has a type, words or a constant.
#[test]
fn schemas_are_strict() {
    for name in SCHEMAS {
        let text = schema_text(name);
        for (place, schema) in places(&text) {
            let states = ["type", "enum", "const", "oneOf", "anyOf"];
            assert!(states.iter().any(|key| schema.get(key).is_some()), "{name}{place}: any value");
            let types = &schema["type"];
            if schema.get("type").is_some() && is_of_type(types, &json!({})) {
                let more = &schema["additionalProperties"];
                let closed = *more == json!(false) && schema["properties"].is_object();
                let map = more.is_object() && schema["propertyNames"].is_object();
                assert!(closed || map, "{name}{place}: an open object");
            }
            if schema.get("type").is_some() && is_of_type(types, &json!([])) {
                assert!(
                    schema["items"].is_object() || schema["maxItems"] == 0,
                    "{name}{place}: an open array"
                );
            }
        }
    }
}

/// The other direction: whatever a schema names, a package has, so that nothing is left of what is written no more.
#[test]
fn schemas_name_nothing_that_is_never_written() {
    let texts: BTreeMap<&str, Value> = SCHEMAS.map(|name| (name, schema_text(name))).into();
    let mut seen: BTreeMap<(&str, String), BTreeSet<String>> = BTreeMap::new();
    for (name, _, value) in &documents() {
        walk(&texts[name], value, &mut |visit| {
            let values = seen.entry((name, visit.place.clone())).or_default();
            values.insert(if visit.schema.get("enum").is_some() {
                visit.value.to_string()
            } else {
                String::new()
            });
            if let Some(object) = visit.value.as_object()
                && visit.schema["propertyNames"].is_object()
            {
                let names =
                    seen.entry((name, format!("{}/propertyNames", visit.place))).or_default();
                names.extend(object.keys().map(|name| json!(name).to_string()));
            }
        });
    }
    let mut unseen = Vec::new();
    for (name, text) in &texts {
        for (place, schema) in places(text) {
            match seen.get(&(*name, place.clone())) {
                None => unseen.push(format!("{name}{place}")),
                Some(values) => {
                    let words =
                        schema["enum"].as_array().into_iter().flatten().map(Value::to_string);
                    unseen.extend(
                        words
                            .filter(|word| !values.contains(word))
                            .map(|word| format!("{name}{place}: {word}")),
                    );
                }
            }
        }
    }
    assert!(unseen.is_empty(), "{unseen:#?}");
}

/// Each place of each schema refuses what is not meant there: another key, a key too few, another type, an unknown word.
#[test]
fn mangled_packages_break_their_schemas() {
    let texts: BTreeMap<&str, Value> = SCHEMAS.map(|name| (name, schema_text(name))).into();
    let validators: BTreeMap<&str, Validator> = SCHEMAS.map(|name| (name, schema(name))).into();
    let (mut done, mut counts, mut accepted) = (BTreeSet::new(), BTreeMap::new(), Vec::new());
    for (name, path, value) in &documents() {
        let mut places = Vec::new();
        walk(&texts[name], value, &mut |visit| {
            if done.insert((*name, visit.place.clone())) {
                places.push((visit.schema.clone(), visit.pointer));
            }
        });
        for (schema, pointer) in places {
            let at = value.pointer(&pointer).unwrap();
            for wrong in wrong_values(&schema, at) {
                let mut mangled = value.clone();
                *mangled.pointer_mut(&pointer).unwrap() = wrong.clone();
                *counts.entry(*name).or_insert(0) += 1;
                if validators[name].is_valid(&mangled) {
                    accepted.push(format!("{path}{pointer}: {wrong}"));
                }
            }
        }
    }
    assert!(accepted.is_empty(), "{accepted:#?}");
    println!("{counts:?}");
    assert!(SCHEMAS.iter().all(|name| counts[name] >= 30), "{counts:?}");
}

/// What a place may not have, made from what it has.
fn wrong_values(schema: &Value, value: &Value) -> Vec<Value> {
    // of no type that any place states together with the one it has
    let mut wrong = vec![match value {
        Value::Bool(_) => json!("true"),
        _ => json!(true),
    }];
    if let Some(object) = value.as_object() {
        let mut more = object.clone();
        more.insert("more".to_owned(), json!(1));
        wrong.push(Value::Object(more));
        for key in schema["required"].as_array().into_iter().flatten() {
            let mut less = object.clone();
            less.remove(key.as_str().unwrap());
            wrong.push(Value::Object(less));
        }
    }
    if schema.get("enum").is_some()
        || schema.get("const").is_some()
        || schema.get("pattern").is_some()
    {
        wrong.push(json!("No such word"));
    }
    for (limit, step) in
        [("minimum", -1.0), ("exclusiveMinimum", 0.0), ("maximum", 1.0), ("exclusiveMaximum", 0.0)]
    {
        wrong.extend(schema[limit].as_f64().map(|limit| json!(limit + step)));
    }
    if let Some(least) = schema["minItems"].as_u64() {
        wrong.push(json!(value.as_array().unwrap()[..least as usize - 1]));
    }
    wrong
}

/// A sum over lobes says what bounds its loops, the same number as in its text.
#[test]
fn bounds_of_lobes_are_those_of_the_text() {
    let text = r#"schema = 1
[[surface]]
name = "blazed"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.2, pixels = 60 }
[variants]
mode = "adaptive"
terms = 9
coherence = ["single", "ensemble"]
[targets]
emit = ["wgsl"]
"#;
    let plan = Plan::parse(text, Path::new("plan.toml")).unwrap();
    let package = Compiler::new(&plan).compile().unwrap_or_else(|e| panic!("{e}"));
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
    let package = package::package();
    let read =
        |path: &str| -> Value { serde_json::from_slice(package.bytes(path).unwrap()).unwrap() };
    let table =
        package.files().keys().find(|path| path.contains("/terms-") && path.ends_with(".json"));
    let variant = format!("{}/manifest.json", package::VARIANT_FOLDER);
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
    let package = package::package();
    let path = format!("{}/probe.json", package::VARIANT_FOLDER);
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
        assert!(tolerance >= CENTRED * greatest("expected"));
        assert!(numbers(&probe["exact"]["xyz"])[1] > 1e-5 * greatest("exact"), "{probe}");
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

/// The words of languages and profiles are those of the code, in its order.
#[test]
fn schemas_name_every_target_and_profile() {
    let targets: Vec<&str> = Target::all().into_iter().map(Target::as_str).collect();
    let profiles: Vec<&str> = Profile::ALL.into_iter().map(Profile::name).collect();
    let (package, variant) = (schema_text("package"), schema_text("variant"));
    for (schema, pointer, words) in [
        (&package, "/properties/targets/items/enum", &targets),
        (&variant, "/properties/targets/propertyNames/enum", &targets),
        (&variant, "/properties/requires/properties/profiles/items/enum", &profiles),
        (&variant, "/properties/requires/properties/gaps/propertyNames/enum", &profiles),
    ] {
        assert_eq!(schema.pointer(pointer), Some(&json!(words)), "{pointer}");
    }
}
