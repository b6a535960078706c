//! `diffraction list` as a user runs it: data on stdout, diagnostics on stderr, exit codes.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use diffraction_shaders::input::read_plan;
use diffraction_shaders::plan::{Key, Variant, vocabulary};
use serde_json::Value;

const PLAN: &str = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 100 }
[variants]
mode = ["full", "pq"]
coherence_scaling = "wavelength"
[[preset]]
name = "as-printed"
basis = "taylor-zero"
packing = "single"
hoist = false
"#;

fn diffraction(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_diffraction"))
        .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .args(args)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn folder(plan: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    folder
}

#[test]
fn json_has_everything_in_the_order_of_the_plan() {
    let done = diffraction(folder(PLAN).path(), &["list", "--json"]);
    assert_eq!((done.status.code(), done.stderr.len()), (Some(0), 0));
    let list: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(list["surfaces"][0]["name"], "a");
    assert_eq!(list["variants"][0]["name"], "full-taylor-t31-lcwave");
    assert_eq!(list["variants"][0]["mode"], "full");
    assert_eq!(list["variants"][0]["cost"][0]["term_fetches"], 81 * 16 * 9);
    assert_eq!(list["variants"][1]["name"], "as-printed");
    assert_eq!(list["variants"][1]["cost"][0]["term_fetches"], 22_599);
    assert_eq!(list["variants"][1]["cost"][0]["fetches"], 22_599 + 81);
    assert_eq!(
        list["targets"],
        serde_json::json!(["wgsl", "glsl450", "glsl-es300", "spirv", "hlsl", "msl"])
    );
    assert_eq!(list["rejected"][0]["name"], "pq-taylor-t31-lcwave");
    let reason = "pq repeats the patch a whole number of times, the same for all wavelengths, so it needs coherence_scaling = \"fixed\"";
    assert_eq!(list["rejected"][0]["reason"], reason);
}

#[test]
fn the_table_tells_costs_and_rejections() {
    let done = diffraction(folder(PLAN).path(), &["list"]);
    let text = String::from_utf8(done.stdout).unwrap();
    for part in [
        "blazed, 2.5 µm",
        "as-printed",
        "22599",
        "pq-taylor-t31-lcwave",
        "a whole number of times",
        "targets: wgsl",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

/// Variants of every mode and with every key away from its default, in as few as that takes.
const FORMS: &str = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 100 }
[variants]
mode = ["full", "pq", "adaptive", "gems", "baked"]
terms = ["auto", 12]
term_error = 0.02
window_radius = 2
periods = [[20, 30], "auto"]
table = ["f16"]
bake_error = 3
bake_mib = 1.5
coherence_um = 40
refractive_index = 1.4
[[preset]]
name = "filtered"
accept_error = true
reconstruction = "prefiltered"
coherence_um = 2
table = "f16"
sampling = "filter"
[[preset]]
name = "sun"
mode = "orders"
lights = ["disc", "environment"]
nodes = "auto"
environment_error = 3.5
pattern = true
period_ratio = [0.6, 1.6]
depth_ratio = [0.9, 1.1]
source_diameter_deg = 0.53
[[preset]]
name = "soft"
mode = "baked"
coherence = "ensemble"
source_diameter_deg = 1
spread_levels = 3
spread_step = 1.5
cells = 64
lights = ["disc", "environment"]
[[preset]]
name = "metal"
mode = "orders"
lights = ["direction"]
material = "copper"
cover_index = 1.5
films = [{ index = 2.2, thickness_nm = 60 }]
obliquity = "unpolarised"
"#;

/// All that a variant reads is in both outputs, whatever keys there are.
#[test]
fn every_key_of_a_configuration_is_listed() {
    let folder = folder(FORMS);
    let plan = read_plan(&folder.path().join("plan.toml")).unwrap();
    let json = diffraction(folder.path(), &["list", "--json"]);
    let list: Value = serde_json::from_slice(&json.stdout).unwrap();
    let human = String::from_utf8(diffraction(folder.path(), &["list"]).stdout).unwrap();
    // another way to write two keys, which are listed
    let is_alias = |key: &Key| key.name == "source_diameter_deg";
    let axes = || vocabulary().into_iter().filter(|key| key.table == "variants" && !is_alias(key));
    let mut read = BTreeSet::new();
    assert_eq!(list["variants"].as_array().unwrap().len(), plan.variants.len());
    for (variant, listed) in plan.variants.iter().zip(list["variants"].as_array().unwrap()) {
        let canonical: Value = serde_json::from_str(&variant.canonical()).unwrap();
        assert_eq!(listed["configuration"], canonical, "{}", variant.name);
        for key in axes().map(|key| key.name) {
            let is_listed = [listed, &listed["optics"]].iter().any(|of| of.get(&key).is_some());
            assert!(is_listed, "{} is listed without {key}", variant.name);
        }
        let reported = reported(&human, variant);
        for (key, value) in canonical.as_object().unwrap() {
            let places = [listed, &listed["optics"], &listed["wavelengths"]];
            assert!(places.iter().any(|of| of.get(key) == Some(value)), "{key} of {listed}");
            let value = match value {
                Value::String(word) => word.clone(),
                Value::Number(n) => n.as_f64().unwrap().to_string(),
                other => other.to_string(),
            };
            let setting = format!("{key} {value}");
            assert!(
                reported.contains(&setting),
                "{}: no {setting:?} in {reported:?}",
                variant.name
            );
            read.insert(key.clone());
        }
    }
    // a plan that reads few keys would show little
    let spectral = ["min_nm", "max_nm", "step_nm"].map(str::to_owned);
    let known = axes().map(|key| key.name).filter(|name| name != "wavelengths").chain(spectral);
    assert_eq!(read, known.collect());
}

/// What the table tells of a variant: the settings of its mode and its own, taken apart.
fn reported(human: &str, variant: &Variant) -> Vec<String> {
    let mut entries: Vec<String> = Vec::new();
    for line in human.lines().skip_while(|line| !line.starts_with("mode ")) {
        match (line.strip_prefix("      "), entries.last_mut()) {
            (Some(rest), Some(entry)) => *entry = format!("{entry} {rest}"),
            _ if line.is_empty() => break,
            _ => entries.push(line.to_owned()),
        }
    }
    let of = |head: String| {
        let entry = entries.iter().find_map(|entry| entry.strip_prefix(head.as_str()));
        entry.unwrap_or_else(|| panic!("{head:?} is not in\n{human}")).trim_start().to_owned()
    };
    let mode = variant.mode.as_str();
    let parts = [of(format!("mode {mode}:")), of(format!("  {}:", variant.name))];
    let settings = parts.iter().flat_map(|part| part.split(", ")).map(str::to_owned);
    settings.chain([format!("mode {mode}")]).collect()
}

/// The widest lines are tables of numbers; what is words is broken.
#[test]
fn the_table_fits_a_terminal_of_100_columns() {
    for plan in [FORMS, PLAN] {
        let text = String::from_utf8(diffraction(folder(plan).path(), &["list"]).stdout).unwrap();
        let wide: Vec<&str> = text.lines().filter(|line| line.chars().count() > 100).collect();
        assert!(wide.is_empty(), "{wide:#?}");
    }
}

#[test]
fn every_fault_of_a_plan_is_one_line_and_the_exit_code_is_two() {
    let broken = PLAN.replace("0.3", "-1").replace("\"full\", \"pq\"", "\"fool\"");
    let folder = folder(&broken);
    let done = diffraction(folder.path(), &["list"]);
    let reported = String::from_utf8(done.stderr).unwrap();
    assert_eq!((done.status.code(), done.stdout.len()), (Some(2), 0));
    assert_eq!(reported.lines().count(), 2, "{reported}");
    assert!(
        reported
            .starts_with("error: plan.toml:4: surface.a.grating.height_um = -1: must be positive"),
        "{reported}"
    );
    let done = diffraction(folder.path(), &["--message-format", "json", "list"]);
    for line in String::from_utf8(done.stderr).unwrap().lines() {
        let object: Value = serde_json::from_str(line).unwrap();
        assert_eq!(object["severity"], "error", "{line}");
    }
    assert_eq!(
        diffraction(folder.path(), &["list", "--plan", "absent.toml"]).status.code(),
        Some(2)
    );
    assert_eq!(diffraction(folder.path(), &["list", "--jsn"]).status.code(), Some(2));
    assert_eq!(diffraction(folder.path(), &[]).status.code(), Some(2));
}

#[test]
fn the_committed_plan_is_sound() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let done = diffraction(root, &["list", "--json"]);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let list: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(list["rejected"].as_array().map(Vec::len), Some(0));
}
