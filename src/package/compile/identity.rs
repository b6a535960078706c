//! Names of computed numbers: hashes of all their inputs. For tables see
//! [`TableSpec::id`](crate::tables::TableSpec::id).

use serde_json::{Value, json};

use crate::hash::{TOOL_VERSION, of_value};
use crate::plan::{Optics, Variant};
use crate::variant::Function;

/// Identity of a function's probes and their exact colours on a surface.
pub(super) fn exact_id(function: &dyn Function, surface: &str, variant: &Variant) -> String {
    let optics = variant.optics.identity();
    let mut inputs = vec![json!(TOOL_VERSION), json!(function.probed()), json!(surface), optics];
    if variant.pattern {
        inputs.push(json!([variant.period_ratio, variant.depth_ratio]));
    }
    format!("exact-{}", of_value(&Value::Array(inputs)))
}

/// Identity of the expected colours of a function's probes.
pub(super) fn expected_id(function: &dyn Function, surface: &str, variant: &Variant) -> String {
    let exact = exact_id(function, surface, variant);
    format!("expected-{}", of_value(&json!([exact, variant.hash()])))
}

/// Identity of the radiance of a surface under a white sky.
pub(super) fn energy_id(surface: &str, optics: &Optics) -> String {
    // the window is no part of it
    let mut inputs = vec![json!(TOOL_VERSION), json!(surface)];
    inputs.extend(optics.without_window());
    let inputs = Value::Array(inputs);
    format!("energy-{}", of_value(&inputs))
}
