//! The modes beside the full sum: each twin against the exact field, the combinations that have no meaning, and every
//! shader that the constraints leave.

use crate::support::package;
use std::path::Path;

use diffraction_shaders::input::load_surface as load;
use diffraction_shaders::plan::{Mode, Plan, Variant};
use diffraction_shaders::shader::emit::emit;
use diffraction_shaders::shader::specialise;
use diffraction_shaders::shader::template::Sources;
use diffraction_shaders::variant::Form;

const SURFACE: &str = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 100 }
"#;

fn plan(keys: &str) -> Plan {
    let text = format!("{SURFACE}[variants]\n{keys}\n");
    Plan::parse(&text, Path::new("plan.toml")).unwrap_or_else(|e| panic!("{keys}: {e}"))
}

fn variant(keys: &str) -> Variant {
    let plan = plan(keys);
    assert_eq!(plan.variants.len(), 1, "{keys}: {:?}", plan.rejected);
    plan.variants[0].clone()
}

#[test]
fn every_shader_that_the_constraints_leave_compiles_for_every_target() {
    let plan = plan(concat!(
        "mode = [\"full\", \"pq\", \"adaptive\", \"gems\", \"baked\", \"orders\"]\nterms = 5\naccept_error = true\n",
        "sampling = [\"load\", \"filter\"]\nbake_mib = 1\n",
        "wavelengths = [{}, { min_nm = 550, max_nm = 550 }]\n",
        r#"table = ["f32", "f16"]
packing = ["paired", "single"]
hoist = [true, false]
"#,
        "coherence = [\"single\", \"ensemble\"]\ncoherence_scaling = [\"fixed\", \"wavelength\"]\n",
        "shadowing = [true, false]\ncolour = [\"srgb\", \"thesis\"]\n",
    ));
    let height = load(&plan.surfaces[0]).unwrap().field;
    let count = |mode| plan.variants.iter().filter(|v| v.mode == mode).count();
    // full: all but hoist = false with an ensemble; pq and adaptive: hoisted only
    assert_eq!(count(Mode::Full), 2 * 2 * 2 * 3 * 2 * 2 * 2);
    assert_eq!(count(Mode::Pq), 2 * 2 * 2 * 2 * 2);
    assert_eq!(count(Mode::Adaptive), 2 * 2 * 2 * 2 * 2 * 2 * 2);
    assert_eq!(count(Mode::Gems), 1);
    // no single wavelength; both samplings, but 32-bit floats are not filtered
    assert_eq!(count(Mode::Baked), 3 * 2 * 2 * 2 * 2);
    // no single wavelength, and lights with a size need a window that follows the wavelength
    assert_eq!(count(Mode::Orders), 2 * 2 * 2);
    for variant in &plan.variants {
        let form = Form::new(variant, &height).unwrap();
        for rotate_deg in [0.0, 30.0] {
            let tables = specialise::shapes(&form, rotate_deg);
            let nodes = specialise::node_count(&tables);
            let defines = specialise::defines(variant, &form, rotate_deg, nodes);
            let module = specialise::shader(&Sources::builtin(), &variant.name, &form, &defines)
                .unwrap_or_else(|e| panic!("{}: {:?}", variant.name, package::lines(&e)));
            for target in package::TARGETS {
                emit(&module, target).unwrap_or_else(|e| panic!("{}: {e}", variant.name));
            }
        }
    }
}

#[test]
fn combinations_without_a_meaning_are_rejected_with_the_reason() {
    for (keys, reason) in [
        ("mode = \"pq\"\ncoherence = \"ensemble\"", "without a coherence window"),
        ("mode = \"pq\"\ncoherence_scaling = \"wavelength\"", "the same for all wavelengths"),
        ("mode = \"pq\"\nhoist = false", "only mode = \"full\" has this form"),
        ("mode = \"adaptive\"\nhoist = false", "only mode = \"full\" has this form"),
        ("coherence = \"ensemble\"\nhoist = false", "adds the intensities of bins"),
        ("table = \"rgb9e5\"", "cannot store negative numbers"),
        (
            "mode = \"baked\"\nwavelengths = { min_nm = 550, max_nm = 550 }",
            "make max_nm larger than min_nm",
        ),
        ("mode = \"baked\"\nsampling = \"filter\"", "32-bit floats"),
        ("mode = \"gems\"\ncolour = \"thesis\"", "needs tristimulus values"),
    ] {
        let text = format!("{SURFACE}[variants]\n{keys}\n");
        let message = Plan::parse(&text, Path::new("plan.toml")).expect_err(keys).to_string();
        assert!(
            message.contains("every combination of [variants] is rejected")
                && message.contains(reason),
            "{keys}: {message}"
        );
        let text = format!(
            r#"{SURFACE}[[preset]]
name = "p"
{keys}
"#
        );
        let message = Plan::parse(&text, Path::new("plan.toml")).expect_err(keys).to_string();
        assert!(message.contains("plan.toml:") && message.contains(reason), "{keys}: {message}");
    }
}

#[test]
fn names_and_hashes_hold_what_the_mode_reads() {
    for (keys, name) in [
        ("mode = \"pq\"", "pq-taylor-t31"),
        ("mode = \"pq\"\nperiods = [3, 2]\ncoherence_um = 30", "pq-taylor-t31-q3x2"),
        ("mode = \"pq\"\ncoherence_um = 30", "pq-taylor-t31-lc30"),
        ("mode = \"adaptive\"\nwindow_radius = 4\nperiods = [2, 2]", "adaptive-taylor-t31"),
        ("mode = \"adaptive\"\nwavelengths = { step_nm = 2 }", "adaptive-taylor-t31"),
        (
            "mode = \"adaptive\"\ncoherence = \"ensemble\"\ntable = \"f16\"",
            "adaptive-taylor-t31-f16-ensemble",
        ),
        (
            r#"mode = "baked"
terms = 3
basis = "optimal"
table = "rgb9e5"
sampling = "filter"
bake_mib = 8"#,
            "baked-rgb9e5-filter-m8",
        ),
        (
            r#"mode = "gems"
terms = 3
basis = "taylor-zero"
hoist = false
refractive_index = 1.6"#,
            "gems",
        ),
    ] {
        assert_eq!(variant(keys).name, name, "{keys}");
    }
    let same = |a: &str, b: &str| variant(a).hash() == variant(b).hash();
    assert!(same("mode = \"adaptive\"", "mode = \"adaptive\"\nwavelengths = { step_nm = 2 }"));
    assert!(same("mode = \"gems\"", "mode = \"gems\"\ncoherence_um = 30"));
    assert!(!same("mode = \"pq\"", "mode = \"pq\"\nperiods = [26, 650]"));
    assert!(!same("mode = \"adaptive\"", "mode = \"full\""));
    assert!(same("mode = \"baked\"", "mode = \"baked\"\nterms = 7\npacking = \"single\""));
    assert!(!same("mode = \"baked\"", "mode = \"baked\"\nbake_error = 0.3"));
    assert!(same("mode = \"full\"", "mode = \"full\"\nbake_error = 0.3"));
    assert_eq!(variant("mode = \"gems\"").canonical(), "{\"mode\":\"gems\"}");
}
