//! What 16-bit tables cost in accuracy, and packages of every mode.

use std::path::Path;

use diffraction_shaders::Compiler;
use diffraction_shaders::field::comparison_directions::on_orders;
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::input::load_surface as load;
use diffraction_shaders::optics::brdf_map::view_directions;
use diffraction_shaders::optics::colour_difference::colour_difference;
use diffraction_shaders::optics::direction;
use diffraction_shaders::package::Package;
use diffraction_shaders::plan::{Plan, TableFormat};
use diffraction_shaders::runner::{Placement, Runner, TwinRunner};
use diffraction_shaders::tables::terms::Terms;
use diffraction_shaders::tables::{TermScale, terms_table};
use diffraction_shaders::variant::Form;
use serde_json::Value;

fn plan(surfaces: &str, keys: &str) -> Plan {
    let text = format!(
        r#"schema = 1
{surfaces}[variants]
{keys}
"#
    );
    Plan::parse(&text, Path::new("plan.toml")).unwrap_or_else(|e| panic!("{keys}: {e}"))
}

const BLAZED: &str = r#"[[surface]]
name = "blazed"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 100 }
"#;
const FINGERS: &str = r#"[[surface]]
name = "fingers"
grating = { kind = "fingers", size_um = 6, pixels = 96, pitch_um = 1.1, height_um = 0.3, seed = 1 }
"#;
const FLAT: &str = r#"[[surface]]
name = "flat"
grating = { kind = "flat", period_um = 25, pixels = 300 }
"#;

/// Rounded tables against the unrounded ones of the same variant.
#[test]
fn sixteen_bits_with_scales_keep_the_colours() {
    let plan = plan(
        &format!("{BLAZED}{FINGERS}"),
        r#"mode = ["full", "pq", "adaptive"]
terms = "auto"
table = ["f16", "f32"]
packing = ["paired", "single"]"#,
    );
    for spec in &plan.surfaces {
        let height = &load(spec).unwrap().field;
        for variant in &plan.variants {
            let wi = direction(20.0, 0.0);
            let mut directions: Vec<Directions> =
                view_directions(24).into_iter().map(|wr| Directions { wi, wr }).collect();
            directions.extend(on_orders(height, &variant.optics, 0.0, wi, 200, 1));
            let placement = Placement { height, rotate_deg: 0.0, variant };
            let colours = |packed: bool| {
                let twin = TwinRunner::new(placement, packed).unwrap();
                twin.tristimulus(&directions).unwrap()
            };
            let found =
                colour_difference(&variant.name, &colours(false), &colours(true), None).unwrap();
            println!(
                "{} {}: max_abs {:.1e}, p95 {:.4}, max {:.4}",
                spec.name, variant.name, found.max_abs, found.de2000.p95, found.de2000.max
            );
            let limit = match variant.table {
                TableFormat::F32 => 1e-3,
                TableFormat::F16 | TableFormat::Rgb9e5 => 1.0,
            };
            assert!(found.de2000.p95 < limit, "{} {}: {found:?}", spec.name, variant.name);
        }
    }
}

/// Without scales the terms of a tall surface leave the range of 16 bits; with them none does.
#[test]
fn terms_of_a_tall_surface_overflow_without_scales() {
    let tall = BLAZED.replace("0.3", "1.5");
    let plan =
        plan(&tall, "mode = \"adaptive\"\nterms = \"auto\"\ntable = \"f16\"\naccept_error = true");
    let (height, variant) = (&load(&plan.surfaces[0]).unwrap().field, &plan.variants[0]);
    let form = Form::new(variant, height).unwrap();
    let series = form.series().unwrap();
    let finite = |scale: TermScale| {
        let terms = Terms::new(height, series.expansion(), series.bins, None);
        let table = terms_table(&terms, variant.packing, variant.table, scale).rounded();
        table.texels.iter().all(|v| v.is_finite())
    };
    assert!(finite(series.scale()) && !finite(TermScale::NONE));
}

#[test]
fn counts_left_to_the_tool_are_sensible_in_every_mode() {
    let plan = plan(
        &format!("{BLAZED}{FINGERS}"),
        "mode = [\"full\", \"pq\", \"adaptive\"]\nterms = \"auto\"\nwindow_radius = \"auto\"",
    );
    for spec in &plan.surfaces {
        let height = &load(spec).unwrap().field;
        for variant in &plan.variants {
            let form = Form::new(variant, height).unwrap();
            println!(
                "{} {}: {} terms, radius {:?}, {:?}",
                spec.name,
                variant.name,
                form.series().unwrap().expansion().terms,
                form.window_radius(),
                form.cost()
            );
            assert!((10..40).contains(&form.series().unwrap().expansion().terms));
            assert!(form.window_radius().is_none_or(|radius| radius <= 3));
            assert!(form.cost().fetches_mean <= form.cost().fetches as f64);
        }
    }
}

fn json(package: &Package, path: &str) -> Value {
    let file = package.bytes(path).unwrap_or_else(|| panic!("{path}"));
    serde_json::from_slice(file).unwrap()
}

#[test]
fn packages_hold_every_mode_and_list_the_gaps() {
    let plan = plan(
        &format!("{BLAZED}{FLAT}"),
        "mode = [\"full\", \"pq\", \"adaptive\", \"gems\"]\nterms = 12\ntable = [\"f32\", \"f16\"]",
    );
    let package = Compiler::new(&plan).compile().unwrap_or_else(|e| panic!("{e}"));
    let gaps: Vec<(&str, &str)> =
        package.gaps().iter().map(|g| (g.surface.as_str(), g.variant.as_str())).collect();
    assert_eq!(
        gaps,
        [("flat", "adaptive-taylor-t12"), ("flat", "adaptive-taylor-t12-f16"), ("flat", "gems")]
    );
    assert_eq!(json(&package, "manifest.json")["gaps"].as_array().map(Vec::len), Some(3));
    let manifest = |name: &str| json(&package, &format!("shaders/blazed/{name}/manifest.json"));
    let gems = manifest("gems");
    assert_eq!(
        (&gems["error_bound"], &gems["core"]["diffuser_scale"]),
        (&Value::Null, &Value::Null)
    );
    assert_eq!(gems["tables"].as_array().map(Vec::len), Some(1));
    assert!(gems["core"]["unit"].as_str().unwrap().contains("no error claimed"));
    let pq = manifest("pq-taylor-t12");
    assert_eq!(pq["configuration"]["periods"], "auto");
    // 65 µm squared against 16π σs²/16 … of the window: the ratio of the two mirrors' lobes
    let scale = |m: &Value| m["core"]["diffuser_scale"].as_f64().unwrap();
    let full = manifest("full-taylor-t12");
    assert!((scale(&pq) / scale(&full) - 16.0 / (4.0 * std::f64::consts::PI)).abs() < 1e-9);
    let half = manifest("adaptive-taylor-t12-f16");
    assert_eq!(half["bindings"][1]["format"], "rgba16float");
    let description = half["tables"][0]["description"].as_str().unwrap();
    let description = description.trim_start_matches("../../../");
    let description = json(&package, description);
    assert_eq!(description["term_scales"].as_array().map(Vec::len), Some(12));
    let bytes = description["bytes"].as_u64().unwrap();
    let (width, height) = (&description["width"], &description["height"]);
    assert_eq!(bytes, 8 * 6 * width.as_u64().unwrap() * height.as_u64().unwrap());
    let bound = |m: &Value| m["error_bound"]["packing"].as_f64().unwrap();
    assert!((bound(&half) / bound(&full) - 8192.0).abs() < 1e-6);
    assert!(half["cost"]["fetches_mean"].as_f64() < full["cost"]["fetches_mean"].as_f64());
}
