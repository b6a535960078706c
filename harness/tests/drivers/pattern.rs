//! Patterns on real drivers: the probes of all functions against the twin, and wrong shaders.

use crate::support::tools::found;
use diffraction_harness::drivers::gpu::{Backend, Gpu};
use diffraction_harness::drivers::{DriverRunner, Prepared};
use diffraction_shaders::plan::{
    Coherence, CoherenceScaling, Grating, LightFunction, Mode, Optics, Variant,
};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::surface::synthetic::synthesise;

/// Faults of the shader: the template, what stands there, and what in its place.
const FAULTS: [(&str, &str, &str); 7] = [
    ("gain", "return pattern.xy;", "return vec2f(pattern.x, -pattern.y);"),
    (
        "gain",
        "return vec2f(own.x * pattern.x - own.y * pattern.y, own.x * pattern.y + own.y * pattern.x);",
        "return own;",
    ),
    ("adaptive", "pattern.z * vec2f", "1.0 * vec2f"),
    ("arrivals", "(pattern.z * vec2f", "(1.0 * vec2f"),
    ("lamps", "reach, ends, pattern.z * PATCH_WIDTH_UM", "reach, ends, PATCH_WIDTH_UM"),
    ("efficiencies", "PHASE_MIN_UM * pattern.w", "PHASE_MIN_UM * 1.0"),
    ("order_path", "let patch_um = pattern.z * vec2f", "let patch_um = 1.0 * vec2f"),
];

#[test]
fn patterns_agree_with_their_twin_and_wrong_ones_do_not() {
    let grating = Grating::Blazed { period_um: 1.5, height_um: 0.25, pixels: 48 };
    let height = synthesise(&grating, "blazed").unwrap().field;
    let optics = Optics {
        coherence: Coherence::Ensemble,
        coherence_scaling: CoherenceScaling::Wavelength,
        ..Optics::standard()
    };
    let variant = Variant {
        name: "foil".into(),
        mode: Mode::Orders,
        lights: vec![
            LightFunction::Direction,
            LightFunction::Disc,
            LightFunction::Polygon,
            LightFunction::Environment,
            LightFunction::Path,
        ],
        pattern: true,
        period_ratio: [0.6, 1.6],
        depth_ratio: [0.5, 1.5],
        ..Variant::texts(&optics)
    };
    for gpu in [Backend::Vulkan, Backend::Gl].into_iter().filter_map(|b| found(Gpu::open(b, None)))
    {
        for rotate_deg in [0.0, 25.0] {
            let placement = Placement { height: &height, rotate_deg, variant: &variant };
            let right = Prepared::new(placement).unwrap();
            let checked = DriverRunner::with(right.clone(), gpu.clone()).checked();
            assert!(checked.is_ok(), "{rotate_deg}: {}", checked.err().unwrap());
            for (name, from, to) in FAULTS {
                // a rotated surface has a line of its own; the others are the same
                let is_of_rotated = name != "gain" || from.contains("own");
                if is_of_rotated != (rotate_deg != 0.0) {
                    continue;
                }
                let mut wrong = right.clone();
                let template = wrong.sources.0.get_mut(name).unwrap();
                assert!(template.contains(from), "{from}");
                *template = template.replace(from, to);
                let checked = DriverRunner::with(wrong, gpu.clone()).checked();
                assert!(checked.is_err(), "{rotate_deg}: {to}");
            }
        }
    }
}
