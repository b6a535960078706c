//! What a surface changes in a plan: optics of its own, and presets that are for some surfaces only.

use std::collections::BTreeSet;
use std::path::Path;

use diffraction_shaders::Compiler;
use diffraction_shaders::input::read_plan;
use diffraction_shaders::package::Package;
use diffraction_shaders::plan::{Coherence, Optics, Plan, SurfaceSpec, Variant};
use diffraction_shaders::survey::survey;
use serde_json::{Value, json};

const GRATING: &str =
    "grating = { kind = \"blazed\", period_um = 1.0, height_um = 0.02, pixels = 16 }";

fn text(first: &str, second: &str, rest: &str) -> String {
    format!(
        r#"schema = 1
[[surface]]
name = "a"
{GRATING}
{first}
[[surface]]
name = "card"
{GRATING}
{second}
{rest}
"#
    )
}

fn plan(first: &str, second: &str, rest: &str) -> Plan {
    Plan::parse(&text(first, second, rest), Path::new("plan.toml")).unwrap()
}

fn errors(first: &str, second: &str, rest: &str) -> String {
    let text = text(first, second, rest);
    let errors = Plan::parse_all(&text, Path::new("plan.toml")).expect_err(&text);
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn surface<'a>(plan: &'a Plan, name: &str) -> &'a SurfaceSpec {
    plan.surface(name).unwrap()
}

/// A variant as it is on a surface.
fn on(plan: &Plan, variant: &str, name: &str) -> Variant {
    plan.variant(Some(variant)).unwrap().on(surface(plan, name)).unwrap().unwrap()
}

#[test]
fn optics_of_a_surface_win_over_those_of_the_plan_and_stated_values_over_both() {
    let plan = plan(
        "",
        "optics = { refractive_index = 1.8, coherence_um = 20 }",
        r#"[optics]
coherence_um = 40
refractive_index = 1.6
[variants]
terms = [3, 5]
coherence_um = [30, 65]
[[preset]]
name = "plain"
[[preset]]
name = "own"
refractive_index = 1.6
"#,
    );
    let numbers = |variant: &str, surface: &str| {
        let Optics { refractive_index, coherence_um, .. } = on(&plan, variant, surface).optics;
        (refractive_index, coherence_um)
    };
    assert_eq!(numbers("plain", "a"), (1.6, 40.0));
    assert_eq!(numbers("plain", "card"), (1.8, 20.0));
    // 1.6 is stated, though `[optics]` says the same
    assert_eq!(numbers("own", "card"), (1.6, 20.0));
    // the axis states the coherence length
    assert_eq!(numbers("full-taylor-t3-lc30-n1p6", "a"), (1.6, 30.0));
    assert_eq!(numbers("full-taylor-t3-lc30-n1p6", "card"), (1.8, 30.0));
    assert_eq!(numbers("full-taylor-t5-n1p6", "card"), (1.8, 65.0));
    // so the two presets are not the same on every surface
    assert!(plan.notes.is_empty(), "{:?}", plan.notes);
    let card = plan.on(surface(&plan, "card"));
    assert_eq!((card.optics.refractive_index, card.optics.coherence_um), (1.8, 20.0));
    assert_eq!(card.variant(Some("texts")).unwrap().optics, card.optics);
    assert_eq!(card.variant(Some("plain")).unwrap(), on(&plan, "plain", "card"));
    // what is on a surface already stays
    assert_eq!(
        on(&card, "plain", "card"),
        on(&plan, "plain", "card"),
        "it is laid on the same surface again"
    );
}

#[test]
fn what_a_mode_does_not_read_stays_at_its_default_on_every_surface() {
    let plan = plan(
        "",
        "optics = { coherence_um = 20, refractive_index = 1.8 }",
        r#"[[preset]]
name = "gems"
mode = "gems"
[[preset]]
name = "copies"
mode = "pq"
periods = [3, 4]
"#,
    );
    let gems = plan.variant(Some("gems")).unwrap();
    assert_eq!(on(&plan, "gems", "card"), gems);
    let copies = on(&plan, "copies", "card");
    assert_eq!((copies.optics.coherence_um, copies.optics.refractive_index), (65.0, 1.8));
    assert_ne!(copies.hash(), plan.variant(Some("copies")).unwrap().hash());
}

#[test]
fn what_the_optics_of_a_surface_make_impossible_is_a_gap_there() {
    let plan = plan(
        "",
        "optics = { coherence = \"ensemble\" }",
        r#"[variants]
mode = ["full", "pq"]
terms = 3
[targets]
emit = "wgsl"
"#,
    );
    assert_eq!(on(&plan, "full-taylor-t3", "card").optics.coherence, Coherence::Ensemble);
    let refused = plan.variant(Some("pq-taylor-t3")).unwrap().on(surface(&plan, "card"));
    let message = refused.unwrap().unwrap_err().to_string();
    assert!(
        message.contains("pq repeats the patch") && message.contains("surface \"card\""),
        "{message}"
    );
    let card = plan.on(surface(&plan, "card"));
    let message = card.variant(Some("pq-taylor-t3")).unwrap_err().to_string();
    assert!(message.contains("pq repeats the patch"), "{message}");
    let (package, gaps) = package(&plan);
    assert_eq!(gaps, ["card pq-taylor-t3"]);
    assert_eq!(folders(&package), ["a/full-taylor-t3", "a/pq-taylor-t3", "card/full-taylor-t3"]);
    let (found, _) = survey(&plan, surface(&plan, "card")).unwrap();
    assert_eq!(found.variants.len(), 1);
    assert!(found.notes.iter().any(|note| note.contains("pq repeats")), "{:?}", found.notes);
}

#[test]
fn presets_are_for_the_surfaces_that_they_name() {
    let plan = plan(
        "",
        "",
        r#"[[preset]]
name = "foil"
surfaces = ["card"]
terms = 3
[[preset]]
name = "both"
terms = 3
[[preset]]
name = "word"
surfaces = "a"
terms = 4
[targets]
emit = "wgsl"
"#,
    );
    assert!(plan.variant(Some("foil")).unwrap().on(surface(&plan, "a")).is_none());
    let names = |name: &str| -> Vec<String> {
        plan.on(surface(&plan, name)).variants.into_iter().map(|v| v.name).collect()
    };
    assert_eq!(names("a"), ["both", "word"]);
    assert_eq!(names("card"), ["foil", "both"]);
    let message = plan.on(surface(&plan, "a")).variant(Some("foil")).unwrap_err().to_string();
    assert!(message.contains("is not for surface \"a\""), "{message}");
    // of one configuration, but not for the same surfaces
    assert!(plan.notes.is_empty(), "{:?}", plan.notes);
    let (package, gaps) = package(&plan);
    assert_eq!(gaps, [""; 0], "what is not wanted is no gap");
    assert_eq!(folders(&package), ["a/both", "a/word", "card/both", "card/foil"]);
    let index: Value = serde_json::from_slice(package.bytes("manifest.json").unwrap()).unwrap();
    assert_eq!(index["variants"]["both"].as_object().unwrap().len(), 1);
    let hash = &index["variants"]["foil"]["configuration_hash"];
    assert_eq!(index["variants"]["foil"]["surfaces"], json!({ "card": hash }));
    let readme = std::str::from_utf8(package.bytes("README.md").unwrap()).unwrap();
    assert_eq!(readme.matches("| foil |").count(), 1, "{readme}");
    assert!(!readme.contains("`foil` is not built"), "{readme}");
    let (found, _) = survey(&plan, surface(&plan, "a")).unwrap();
    assert_eq!(found.variants.iter().map(|v| v.name.as_str()).collect::<Vec<_>>(), names("a"));
}

#[test]
fn a_surface_without_variants_is_said() {
    let plan = plan(
        "",
        "",
        r#"[[preset]]
name = "foil"
surfaces = ["card"]
"#,
    );
    assert_eq!(plan.notes, ["a: no variant is for this surface"]);
    let alone = Plan { surfaces: plan.surfaces[..1].to_vec(), ..plan.clone() };
    let message = Compiler::new(&alone).compile().unwrap_err().to_string();
    assert!(message.contains("no variant is for a surface"), "{message}");
}

/// A short wavelength asks a fine pitch of the surfaces that it is wanted on.
#[test]
fn the_pitch_of_a_surface_follows_its_own_variants() {
    let rest = |surfaces: &str| {
        format!(
            r#"[[preset]]
name = "short"
surfaces = ["{surfaces}"]
[[preset]]
name = "long"
wavelengths = {{ min_nm = 500 }}
"#
        )
    };
    // 0.1 µm: enough for 400 nm, too coarse for 380 nm
    let coarse =
        |surfaces: &str| text("", "", &rest(surfaces)).replacen("pixels = 16", "pixels = 10", 1);
    assert!(Plan::parse(&coarse("card"), Path::new("plan.toml")).is_ok());
    let message = Plan::parse(&coarse("a"), Path::new("plan.toml")).unwrap_err().to_string();
    assert!(message.contains("surface.a.grating.pixels = 10"), "{message}");
}

#[test]
fn faults_are_told() {
    for (second, rest, expected) in [
        (
            "optics = { refractive_idx = 1.8 }",
            "",
            "plan.toml:9: unknown key surface.card.optics.refractive_idx (did you mean \"refractive_index\"?)",
        ),
        ("optics = { terms = 3 }", "", "unknown key surface.card.optics.terms"),
        (
            "optics = { refractive_index = \"glass\" }",
            "",
            "surface.card.optics.refractive_index = \"glass\": is a string (expected a number",
        ),
        (
            "optics = { refractive_index = [1.5, 1.6] }",
            "",
            "surface.card.optics.refractive_index = [1.5, 1.6]: is an array (expected one value",
        ),
        ("optics = { coherence = \"ensembel\" }", "", "did you mean \"ensemble\"?"),
        ("optics = 1.8", "", "surface.card.optics = 1.8: is a float (expected a table"),
        ("optics = []", "", "surface.card.optics = []: is an array"),
        (
            "optic = { refractive_index = 1.8 }",
            "",
            "unknown key surface[2].optic (did you mean \"optics\"?)",
        ),
        (
            "",
            "[[preset]]\nname = \"p\"\nsurfaces = [\"crad\"]",
            "plan.toml:12: preset.p.surfaces[1] = \"crad\": is not a surface of the plan (did you mean \"card\"?)",
        ),
        (
            "",
            "[[preset]]\nname = \"p\"\nsurfaces = []",
            "preset.p.surfaces = []: is empty (list at least one surface, or remove the key)",
        ),
        (
            "",
            "[[preset]]\nname = \"p\"\nsurfaces = [1]",
            "preset.p.surfaces[1] = 1: is an integer (expected a string: the name of a surface)",
        ),
        ("", "[[preset]]\nname = \"p\"\nsurfaces = true", "preset.p.surfaces = true: is a boolean"),
        (
            "",
            "[[preset]]\nname = \"p\"\nsurfaces = [\"a\", \"a\"]",
            "preset.p.surfaces[2] = \"a\": is listed twice (remove one of the two)",
        ),
        ("", "[variants]\nsurfaces = [\"a\"]", "unknown key variants.surfaces"),
    ] {
        let message = errors("", second, rest);
        assert!(message.contains(expected), "{second} {rest}\n message {message}\n not {expected}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

#[test]
fn illuminants_of_surfaces_are_read_from_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.toml");
    let lamp = "optics = { illuminant = \"lamp.csv\" }";
    std::fs::write(&path, text("", lamp, "[variants]\nterms = 2\n")).unwrap();
    let message = read_plan(&path).unwrap_err()[0].to_string();
    assert!(message.contains("lamp.csv"), "{message}");
    let hash = |content: &str| {
        std::fs::write(folder.path().join("lamp.csv"), content).unwrap();
        let plan = read_plan(&path).unwrap();
        let card = on(&plan, "full-taylor-t2", "card");
        assert!(card.optics.illuminant.content().is_some());
        Compiler::new(&plan).input_hash().unwrap()
    };
    let one = hash("nm,power\n300,1\n900,1\n");
    assert_ne!(one, hash("nm,power\n300,1\n900,2\n"), "another content is another package");
}

/// Two surfaces of the same heights: each has what a plan of its optics alone would give it.
#[test]
fn a_package_has_the_optics_of_each_surface() {
    const REST: &str = r#"[[preset]]
name = "sum"
terms = 3
wavelengths = { step_nm = 100 }
[[preset]]
name = "stated"
terms = 3
refractive_index = 1.4
wavelengths = { step_nm = 100 }
[[preset]]
name = "colours"
mode = "baked"
bake_error = 10
bake_mib = 0.25
[targets]
emit = ["wgsl", "glsl-es300"]
"#;
    let own = "optics = { refractive_index = 1.8, coherence_um = 5, illuminant = \"A\" }";
    let both = plan("", own, REST);
    let (made, gaps) = package(&both);
    assert_eq!(gaps, [""; 0]);
    let alone = r#"[optics]
refractive_index = 1.8
coherence_um = 5
illuminant = "A"
"#;
    let (expected, _) = package(&plan("", "", &format!("{alone}{REST}")));
    let (plain, _) = package(&plan("", "", REST));
    let of = |package: &Package, surface: &str| -> Vec<(String, Vec<u8>)> {
        let paths = package.files().keys().filter(|path| {
            ["shaders", "surfaces"].iter().any(|top| path.starts_with(&format!("{top}/{surface}/")))
        });
        paths.map(|path| (path.clone(), package.bytes(path).unwrap().to_vec())).collect()
    };
    assert!(of(&made, "card") == of(&expected, "card"), "as if the plan had its optics");
    assert!(of(&made, "a") == of(&plain, "a"), "as if no surface had its own");
    assert!(of(&made, "card") != of(&plain, "card"));
    let manifest = |surface: &str, variant: &str| -> Value {
        let path = format!("shaders/{surface}/{variant}/manifest.json");
        serde_json::from_slice(made.bytes(&path).unwrap()).unwrap()
    };
    let (a, card) = (manifest("a", "sum"), manifest("card", "sum"));
    assert_eq!(a["configuration"]["refractive_index"], 1.5);
    assert_eq!(card["configuration"]["refractive_index"], 1.8);
    assert_eq!(manifest("card", "stated")["configuration"]["refractive_index"], 1.4);
    assert_eq!(card["configuration_hash"], on(&both, "sum", "card").hash());
    assert_ne!(a["core"]["diffuser_scale"], card["core"]["diffuser_scale"]);
    // the heights are the same, and terms ask for nothing else; the light is not
    let tables = |surface: &str, variant: &str| -> BTreeSet<String> {
        let manifest = manifest(surface, variant);
        let tables = manifest["tables"].as_array().unwrap().iter();
        tables.map(|table| table["id"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(tables("a", "sum").intersection(&tables("card", "sum")).count(), 1);
    assert!(tables("a", "colours").is_disjoint(&tables("card", "colours")));
    let index: Value = serde_json::from_slice(made.bytes("manifest.json").unwrap()).unwrap();
    let hashes = &index["variants"]["sum"]["surfaces"];
    assert_eq!(hashes["card"], card["configuration_hash"]);
    assert_eq!(hashes["a"], index["variants"]["sum"]["configuration_hash"]);
    let index: Value = serde_json::from_slice(plain.bytes("manifest.json").unwrap()).unwrap();
    assert!(index["variants"]["sum"].get("surfaces").is_none());
}

/// The sealed package, and its gaps.
fn package(plan: &Plan) -> (Package, Vec<String>) {
    let package = Compiler::new(plan).compile().unwrap_or_else(|errors| panic!("{errors}"));
    let gaps =
        package.gaps().iter().map(|gap| format!("{} {}", gap.surface, gap.variant)).collect();
    (package, gaps)
}

/// `surface/variant` of every shader.
fn folders(package: &Package) -> Vec<String> {
    let paths = package.files().keys().filter_map(|path| path.strip_prefix("shaders/"));
    paths.filter_map(|path| path.strip_suffix("/manifest.json")).map(str::to_owned).collect()
}
