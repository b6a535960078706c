//! The manual's list of axes, against the plan's own.

use std::fs;
use std::path::Path;

use diffraction_shaders::plan::{AxisDoc, axis_docs};
use serde_json::Value;

/// What the manual of plans has to say of all axes.
fn table() -> String {
    let rows = axis_docs().iter().map(row).collect::<String>();
    format!("| key | values | default | what it is |\n| --- | --- | --- | --- |\n{rows}")
}

fn row(axis: &AxisDoc) -> String {
    let AxisDoc { key, words, values, default, about, .. } = axis;
    let words = words.iter().map(|word| format!("`{word}`"));
    let values = (!values.is_empty()).then(|| (*values).to_owned());
    let values: Vec<String> = words.chain(values).collect();
    format!("| `{key}` | {} | {} | {about} |\n", values.join(", "), shown(default))
}

fn shown(default: &Value) -> String {
    match default {
        Value::Null => "none".to_owned(),
        Value::String(word) => format!("`{word}`"),
        // whole numbers are written without a point
        Value::Number(n) => format!("`{}`", n.as_f64().unwrap_or_default()),
        Value::Object(entries) => {
            let entry = |(key, value): (&String, &Value)| format!("{key} {}", shown(value));
            entries.iter().map(entry).collect::<Vec<_>>().join(", ")
        }
        other => format!("`{other}`"),
    }
}

#[test]
fn the_readme_lists_every_axis() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/plan.md");
    let manual = fs::read_to_string(path).expect("the manual");
    let start = manual.find("| key | values | default |").expect("the list of axes");
    let found = manual[start..].split("\n\n").next().unwrap_or_default().trim_end();
    let expected = table();
    assert_eq!(found, expected.trim_end(), "the list of axes has to be\n{expected}");
}

/// One line each, which says more than the key.
#[test]
fn every_axis_is_described() {
    for axis in axis_docs() {
        assert!(axis.about.len() > 5 && !axis.about.contains(['\n', '|']), "{}", axis.key);
        assert!(!axis.words.is_empty() || !axis.values.is_empty(), "{}", axis.key);
        assert!(!axis.values.contains(['\n', '|']), "{}", axis.key);
    }
}
