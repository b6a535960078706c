//! Wider lobes on real drivers: the probes of all functions of a variant against its twin, and wrong shaders.

use crate::support::tools::found;
use diffraction_harness::drivers::gpu::{Backend, Gpu};
use diffraction_harness::drivers::{DriverRunner, Prepared};
use diffraction_shaders::plan::{
    Auto, Coherence, CoherenceScaling, Grating, Mode, Optics, Sampling, TableFormat, Variant,
};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;

fn fingers() -> HeightField {
    let text = r#"{ "kind": "fingers", "size_um": 6.6, "pixels": 90, "pitch_um": 1.1, "height_um": 0.3, "seed": 3 }"#;
    synthesise(&serde_json::from_str::<Grating>(text).unwrap(), "fingers").unwrap().field
}

/// Six tables of wider lobes with the step for lamps.
fn soft(table: TableFormat, sampling: Sampling) -> Variant {
    let optics = Optics {
        coherence: Coherence::Ensemble,
        coherence_scaling: CoherenceScaling::Wavelength,
        coherence_um: 90.0,
        ..Optics::standard()
    };
    Variant {
        name: "soft".into(),
        mode: Mode::Baked,
        table,
        sampling,
        bake_mib: 8.0,
        bake_error: 0.5,
        spread_levels: Auto::Value(6),
        spread_step: std::f64::consts::SQRT_2,
        hoist: true,
        ..Variant::texts(&optics)
    }
}

fn adapters() -> Vec<Gpu> {
    [Backend::Vulkan, Backend::Gl].into_iter().filter_map(|b| found(Gpu::open(b, None))).collect()
}

/// Faults of the shader: the template, what stands there, and what in its place.
const FAULTS: [(&str, &str, &str); 8] = [
    ("baked", "wide_between(path, level)", "wide_between(path, level + 1)"),
    ("baked", "wider_share(wanted / own)) / own;", "wider_share(wanted / own));"),
    ("baked", "let away = lobe.x * size;", "let away = 1.0 * size;"),
    ("baked", "lobe_at(wi.xy + wr.xy, spread) * image", "0.0 * image"),
    ("cells", "place.z * inverseSqrt(wi.z)", "0.0 * place.z"),
    ("cells", "gain(wi, wr) / wi.z * mix(", "gain(wi, wr) * mix("),
    (
        "baked",
        "spread * spread / (LOBE_SIGMA * LOBE_SIGMA)",
        "spread * spread / (2.0 * LOBE_SIGMA * LOBE_SIGMA)",
    ),
    ("baked", "(variance - 1.0) / (LEVEL_RATIO - 1.0)", "0.0 * variance"),
];

#[test]
fn wider_lobes_agree_with_their_twin_and_wrong_ones_do_not() {
    let height = fingers();
    for (gpu, (table, sampling)) in adapters().into_iter().flat_map(|gpu| {
        let forms = [
            (TableFormat::F32, Sampling::Load),
            (TableFormat::F16, Sampling::Filter),
            (TableFormat::Rgb9e5, Sampling::Load),
        ];
        forms.map(move |form| (gpu.clone(), form))
    }) {
        let variant = soft(table, sampling);
        let placement = Placement { height: &height, rotate_deg: 25.0, variant: &variant };
        let right = Prepared::new(placement).unwrap();
        let checked = DriverRunner::with(right.clone(), gpu.clone()).checked();
        assert!(checked.is_ok(), "{table:?} {sampling:?}: {}", checked.err().unwrap());
        for (name, from, to) in FAULTS {
            let mut wrong = right.clone();
            let template = wrong.sources.0.get_mut(name).unwrap();
            assert!(template.contains(from), "{from}");
            *template = template.replace(from, to);
            let checked = DriverRunner::with(wrong, gpu.clone()).checked();
            assert!(checked.is_err(), "{table:?} {sampling:?}: {to}");
        }
    }
}
