//! Writes a variant as a preset of a plan.

use diffraction_shaders::plan::{Mode, Optics, Variant};
use serde_json::{Map, Value, json};

use super::grid;

/// The text of a `[[preset]]` that gives this variant in a plan with these `[optics]`. Keys that the variant's mode does not read
/// are left out.
pub fn preset(variant: &Variant, optics: &Optics) -> String {
    let settings: Map<String, Value> =
        serde_json::from_str(&variant.canonical()).unwrap_or_default();
    let plain = serde_json::to_value(optics).unwrap_or_default();
    let mut keys: Vec<(&str, String)> = Vec::new();
    for (key, value) in &settings {
        match key.as_str() {
            "min_nm" | "max_nm" | "step_nm" => {}
            // the plan has this value already
            key if plain.get(key) == Some(value) => {}
            // strings, numbers, booleans and lists of numbers are the same in JSON and in TOML
            key => keys.push((key, value.to_string())),
        }
    }
    if variant.mode == Mode::Pq {
        // a key that this mode does not read may still contradict it, if the plan sets it for all
        let neutral = [("coherence", "single"), ("coherence_scaling", "fixed")];
        let said = neutral.into_iter().filter(|(key, word)| plain[*key] != json!(word));
        keys.extend(said.map(|(key, word)| (key, format!("\"{word}\""))));
    }
    let place = |key: &str| ORDER.iter().position(|known| *known == key).unwrap_or(ORDER.len());
    keys.sort_by_key(|(key, _)| place(key));
    let nm = ["min_nm", "max_nm", "step_nm"].into_iter();
    let nm: Vec<String> =
        nm.filter_map(|key| Some(format!("{key} = {}", settings.get(key)?))).collect();
    if !nm.is_empty() {
        keys.push(("wavelengths", format!("{{ {} }}", nm.join(", "))));
    }
    text(&short(variant), &keys)
}

/// Maximum length of a preset's name.
const MAX_NAME: usize = 64;

/// The variant's name. If it is too long for a preset: its beginning, and the beginning of the hash.
fn short(variant: &Variant) -> String {
    if variant.name.len() <= MAX_NAME {
        return variant.name.clone();
    }
    let begin: String = variant.name.chars().take(MAX_NAME - 9).collect();
    format!("{begin}-{}", &variant.hash()[..8])
}

/// Keys that come first. Others follow.
const ORDER: [&str; 9] = [
    "mode",
    "basis",
    "terms",
    "term_error",
    "reconstruction",
    "sampling",
    "window_radius",
    "periods",
    "table",
];

/// The text of a preset of the grid. The value of `wavelengths` is the step.
pub(super) fn of_grid(name: &str, keys: &[(&str, String)]) -> String {
    let whole = |(key, value): &(&'_ str, String)| match *key {
        "wavelengths" => grid::wavelengths(value),
        _ => value.clone(),
    };
    let keys: Vec<(&str, String)> = keys.iter().map(|pair| (pair.0, whole(pair))).collect();
    text(name, &keys)
}

fn text(name: &str, keys: &[(&str, String)]) -> String {
    let lines = keys.iter().map(|(key, value)| format!("{key} = {value}\n"));
    format!("[[preset]]\nname = \"{name}\"\n{}", lines.collect::<String>())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use diffraction_shaders::plan::Plan;

    #[test]
    fn a_preset_that_is_read_again_is_the_same_variant() {
        let text = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "flat", period_um = 2.5, pixels = 100 }
[optics]
coherence_um = 50
coherence = "ensemble"
[variants]
mode = ["full", "adaptive"]
basis = ["taylor", "optimal"]
terms = [7, "auto"]
term_error = [0.02]
window_radius = ["auto", 2]
wavelengths = [{ min_nm = 400, step_nm = 2.5 }]
table = ["f16"]
shadowing = [false]
[[preset]]
name = "replicas"
mode = "pq"
coherence = "single"
periods = [5, 7]
packing = "single"
[[preset]]
name = "gems"
mode = "gems"
"#;
        let plan = Plan::parse(text, Path::new("plan.toml")).expect("a plan");
        assert_eq!(plan.variants.len(), 2 * 2 * 2 + 4 + 2);
        for variant in &plan.variants {
            let text = preset(variant, &plan.optics);
            let read = plan.preset(&text).unwrap_or_else(|e| panic!("{text}{e:?}"));
            assert_eq!((&read.name, read.hash()), (&short(variant), variant.hash()), "{text}");
            // what is configured for the whole plan is not said again
            let settings = text.lines().filter(|line| !line.starts_with("name"));
            let said = settings.collect::<Vec<_>>().join("\n");
            let own = ["ensemble", "coherence_um"].iter().all(|word| !said.contains(word));
            assert!(own || variant.mode.as_str() == "pq", "{text}");
        }
    }
}
