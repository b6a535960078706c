//! Names of tables against a second opinion: what each table depends on, written out by hand.

use std::collections::BTreeMap;
use std::path::Path;

use diffraction_shaders::input::{SurfaceInput, read_surfaces};
use diffraction_shaders::plan::{
    Auto, Basis, Medium, Mode, Plan, Reconstruction, TableFormat, Variant, Window,
};
use diffraction_shaders::tables::{TableSpec, strongest_period_um};
use diffraction_shaders::variant::{Form, Ground};
use serde_json::{Value, json};

const SURFACES: &str = r#"schema = 1
[[surface]]
name = "blazed"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 60 }
rotate_deg = 25.0
[[surface]]
name = "domes"
grating = { kind = "bumps", size_um = 4, pixels = 48, pitch_um = 1.5, height_um = 0.3, seed = 3 }
"#;

const VARIANTS: &str = r#"
[optics]
coherence_um = 20
[variants]
mode = ["full", "pq", "adaptive", "baked", "gems"]
basis = ["taylor", "optimal"]
terms = [5, "auto"]
term_error = [0.1]
reconstruction = ["window", "prefiltered"]
window_radius = [0, "auto"]
wavelengths = [{}, { min_nm = 400, step_nm = 10 }]
table = ["f32", "f16"]
packing = ["paired", "single"]
bake_mib = 0.5
coherence = ["single", "ensemble"]
illuminant = ["D65", "A"]
"#;

/// More of the optics, for fewer forms.
const OPTICS: &str = r#"
[variants]
mode = ["full", "pq", "adaptive", "baked", "orders"]
terms = [5, 6]
wavelengths = [{}, { max_nm = 700 }]
reconstruction = ["window", "prefiltered"]
window_radius = ["auto"]
table = ["f16"]
bake_mib = [0.5, 0.25]
bake_error = [0.5, 2]
coherence = "ensemble"
coherence_um = [5, 20]
coherence_scaling = ["fixed", "wavelength"]
refractive_index = [1.5, 1.3]
shadowing = [true, false]
[[preset]]
name = "single"
mode = "adaptive"
reconstruction = "prefiltered"
terms = 5
coherence_um = 5
[[preset]]
name = "single-longer"
mode = "adaptive"
reconstruction = "prefiltered"
terms = 5
coherence_um = 7
[[preset]]
name = "periods"
mode = "pq"
terms = 5
window_radius = "auto"
periods = [3, 4]
"#;

/// Metals, covers and films.
const MATTER: &str = r#"
[variants]
mode = ["full", "adaptive", "baked", "orders"]
basis = "optimal"
terms = 8
lights = [["direction"]]
wavelengths = [{}, { max_nm = 700 }]
bake_mib = 0.5
coherence_um = 20
coherence = "ensemble"
material = ["dielectric", "gold"]
refractive_index = [1.5, 1.3]
cover_index = [1, 1.4, "polycarbonate"]
films = [[], [{ index = 1.4, thickness_nm = 90 }]]
obliquity = ["stam", "te"]
illuminant = ["D65", "A"]
"#;

/// What a table depends on beside the tool's version; `forget`: a key that a careless list would lack.
fn inputs(spec: &TableSpec, surface: &SurfaceInput, variant: &Variant, forget: &str) -> Value {
    let (waves, optics) = (&variant.wavelengths, &variant.optics);
    let Window { coherence_um, coherence, coherence_scaling } = Window::from(optics);
    let coherence_um = if forget == "coherence_um" { 0.0 } else { coherence_um };
    let light = optics.illuminant.identity();
    let (id, rotate_deg) = (surface.identity(), surface.spec().rotate_deg);
    let matter = optics.matter().map(|matter| json!([matter, light]));
    let matter = if forget == "material" { None } else { matter };
    // phases and the rows about the matter depend on the ends of the range
    let phases = optics.matter().map(|_| json!([optics.cover_index, waves.max_nm]));
    let prefiltered = variant.reconstruction == Reconstruction::Prefiltered;
    let count = match variant.terms {
        Auto::Value(n) if variant.basis == Basis::Optimal => json!([n, light, waves.max_nm]),
        Auto::Value(n) => json!(n),
        Auto::Auto => json!([variant.term_error]),
    };
    let reach = match (variant.mode, variant.window_radius) {
        _ if prefiltered => json!(["prefiltered", coherence_um]),
        (Mode::Adaptive, _) => json!(["lobes", coherence_um, coherence_scaling, waves.max_nm]),
        (_, Auto::Value(radius)) => json!(radius),
        (Mode::Pq, Auto::Auto) => json!(["pq", variant.periods, coherence_um]),
        (_, Auto::Auto) => json!([coherence_um, coherence_scaling, waves.max_nm]),
    };
    let packing = if forget == "packing" { Value::Null } else { json!(variant.packing) };
    let covered = if optics.cover_index == Medium::Constant(1.0) { None } else { phases };
    let terms =
        json!([id, variant.basis, count, reach, waves.min_nm, packing, variant.table, covered]);
    // the scales of 16-bit terms are in the spectrum
    let scales = if variant.table == TableFormat::F16 { terms.clone() } else { Value::Null };
    match spec {
        TableSpec::Terms(_) => terms,
        TableSpec::Coefficients(_) => {
            json!([id, variant.basis, count, waves.min_nm, prefiltered, covered])
        }
        TableSpec::OrderPaths(_) => json!([id, waves.min_nm, waves.max_nm, light, covered]),
        TableSpec::ColourPaths(_) => json!([
            [id, waves.min_nm, waves.max_nm, variant.table, variant.bake_error, variant.bake_mib],
            [coherence_um, coherence, coherence_scaling, light, matter]
        ]),
        TableSpec::Cells(_) => {
            let normal = matter.is_none().then_some(optics.refractive_index);
            json!([
                [id, waves.min_nm, waves.max_nm, variant.cells, normal],
                [coherence_um.min(25.0), light, matter]
            ])
        }
        TableSpec::Colours(_) => json!([
            [id, waves.min_nm, waves.max_nm, variant.table, variant.bake_error, variant.bake_mib],
            [coherence_um, coherence, coherence_scaling, light, matter]
        ]),
        TableSpec::Wide(_) | TableSpec::Spreads(_) => {
            let (levels, step) = (variant.spread_levels.to_string(), variant.spread_step);
            let step = if forget == "spread_step" { 0.0 } else { step };
            let wide = json!([
                [id, waves.min_nm, waves.max_nm, variant.table, variant.bake_error],
                [coherence_um, light, matter, variant.bake_mib, levels, step]
            ]);
            let normal = matter.is_none().then_some(optics.refractive_index);
            match spec {
                TableSpec::Spreads(_) => json!([wide, rotate_deg, normal]),
                _ => wide,
            }
        }
        TableSpec::Nodes(_) => json!([light, waves, rotate_deg, scales, matter]),
        TableSpec::Levels(_) => {
            json!([
                [id, coherence_um, light, waves.min_nm, waves.max_nm, rotate_deg, scales],
                matter
            ])
        }
        TableSpec::Lobes(_) => json!([
            [light, waves.min_nm, waves.max_nm, rotate_deg, scales],
            [id, coherence_scaling, matter]
        ]),
        TableSpec::Grating(_) => json!(id),
        TableSpec::Rotation(_) => json!(rotate_deg),
        TableSpec::Efficiencies(_) => {
            // the greatest phase is at the shortest wavelength
            let cover = covered.map(|_| &optics.cover_index);
            json!([id, waves.min_nm, cover])
        }
        TableSpec::Moments(_) => json!([light, waves.min_nm, waves.max_nm]),
        TableSpec::Streaks(_) => {
            json!([light, waves.min_nm, waves.max_nm, variant.nodes.to_string()])
        }
    }
}

/// Wider lobes.
const SPREADS: &str = r#"
[variants]
mode = "baked"
table = ["f16", "f32"]
bake_mib = [0.5, 0.25]
bake_error = 2
coherence = "ensemble"
coherence_um = [5, 20]
coherence_scaling = "wavelength"
lights = [["direction"], ["disc"]]
material = ["dielectric", "gold"]
refractive_index = [1.5, 1.3]
spread_levels = [0, 1, 3]
spread_step = [1.5, 2]
illuminant = ["D65", "A"]
"#;

/// Tables that two names or two lists of inputs tell apart, and those that only one of both does.
fn compare(forget: &str) -> (usize, Vec<String>) {
    let mut of_inputs: BTreeMap<(String, String), String> = BTreeMap::new();
    let mut of_ids: BTreeMap<(String, String), String> = BTreeMap::new();
    let mut wrong = Vec::new();
    for variants in [VARIANTS, OPTICS, MATTER, SPREADS] {
        let plan = Plan::parse(&format!("{SURFACES}{variants}"), Path::new("plan.toml")).unwrap();
        for surface in &read_surfaces(&plan.surfaces).unwrap() {
            let field = &surface.surface().unwrap().field;
            let ground =
                Ground { surface: surface.identity(), rotate_deg: surface.spec().rotate_deg };
            for variant in &plan.variants {
                let Ok(form) = Form::new(variant, field) else { continue };
                for spec in form.tables(ground) {
                    let inputs = inputs(&spec, surface, variant, forget).to_string();
                    let (name, id) = (spec.shape().name.to_owned(), spec.id());
                    assert!(id.starts_with(&name), "{id}");
                    // tables of different surfaces lie in different folders
                    let name = format!("{} {name}", surface.spec().name);
                    let one = of_inputs.entry((name.clone(), inputs.clone())).or_insert(id.clone());
                    if *one != id {
                        wrong.push(format!("{} has {id} and {one} of {inputs}", variant.name));
                    }
                    let other = of_ids.entry((name, id.clone())).or_insert(inputs.clone());
                    if *other != inputs {
                        wrong.push(format!("{}: {id} of {inputs} and {other}", variant.name));
                    }
                }
            }
        }
    }
    (of_ids.len(), wrong)
}

#[test]
fn tables_have_one_name_exactly_if_they_have_the_same_inputs() {
    let (count, wrong) = compare("");
    assert!(count > 300, "{count}");
    assert!(wrong.is_empty(), "{} of {count}, first {}", wrong.len(), wrong[0]);
}

#[test]
fn a_forgotten_input_shows() {
    for forgotten in ["packing", "coherence_um", "material", "spread_step"] {
        assert!(!compare(forgotten).1.is_empty(), "{forgotten}");
    }
}

/// What is left out of an identity on purpose: how a shader reads a table.
#[test]
fn filtering_and_loading_share_a_table() {
    let text = format!(
        r#"{SURFACES}[variants]
mode = "baked"
table = "f16"
sampling = ["load", "filter"]
"#
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap();
    let surface = SurfaceInput::read(&plan.surfaces[0]).unwrap();
    let field = &surface.surface().unwrap().field;
    assert!(strongest_period_um(field).is_some());
    let ids = |variant: &Variant| -> Vec<String> {
        let ground = Ground { surface: surface.identity(), rotate_deg: 25.0 };
        Form::new(variant, field).unwrap().tables(ground).iter().map(TableSpec::id).collect()
    };
    assert_eq!(ids(&plan.variants[0]), ids(&plan.variants[1]));
}
