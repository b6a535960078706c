//! Drivers that answer wrongly are caught before their first result.

use crate::support::tools::found;
use diffraction_harness::drivers::gpu::{Backend, Gpu};
use diffraction_harness::drivers::{DriverRunner, Prepared, ShaderRunner, check};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::optics::colour_difference::colour_difference;
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{
    Auto, Basis, Coherence, CoherenceScaling, LightFunction, Mode, Optics, Packing, Sampling,
    TableFormat, Variant, Wavelengths,
};
use diffraction_shaders::runner::{Exact, Placement, Runner, TwinRunner, rounded};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;

/// 96 × 96 pixels of domes.
fn relief() -> HeightField {
    let text = r#"{ "kind": "bumps", "size_um": 6.0, "pixels": 96, "pitch_um": 1.2, "height_um": 0.25, "seed": 5 }"#;
    synthesise(&serde_json::from_str(text).unwrap(), "relief").unwrap().field
}

/// The full sum in steps of 1 nm.
fn fine(terms: u32, window_radius: u32) -> Variant {
    let texts = Variant::texts(&Optics::standard());
    Variant {
        name: "fine".into(),
        basis: Basis::Taylor,
        terms: Auto::Value(terms),
        packing: Packing::Paired,
        hoist: true,
        accept_error: false,
        window_radius: Auto::Value(window_radius),
        wavelengths: Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm: 1.0 },
        ..texts
    }
}

/// Mesa's software drivers end the loops of a pixel after 65535 steps and go on with what they have.
#[test]
fn loops_that_a_driver_ends_early_are_caught() {
    let height = relief();
    let deep = fine(31, 8);
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &deep };
    for backend in [Backend::Gl, Backend::Vulkan] {
        let Some(gpu) = found(Gpu::open(backend, Some("llvmpipe"))) else { continue };
        let error = ShaderRunner::new(placement, gpu).unwrap().checked().map(|_| ()).unwrap_err();
        assert!(error.is_finding());
        let message = error.to_string();
        let parts = ["llvmpipe", "gives wrong colours for fine", "65535 steps", "--unchecked"];
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }
}

/// Four layers in a step of the innermost loop: what was off by 0.85 of the maximum is right.
#[test]
fn a_fine_sum_takes_few_steps() {
    let height = relief();
    for terms in [19, 31] {
        let variant = fine(terms, 2);
        let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
        let light = rounded(direction(20.0, 10.0));
        let twin = TwinRunner::new(placement, true).unwrap().brdf_map(light, 24).unwrap().disc();
        for backend in [Backend::Gl, Backend::Vulkan] {
            let Some(gpu) = found(Gpu::open(backend, None)) else { continue };
            let runner = ShaderRunner::new(placement, gpu).unwrap().checked().unwrap();
            let map = runner.brdf_map(light, 24).unwrap().disc();
            let apart = colour_difference("fine", &twin, &map, None).unwrap();
            println!("{terms} terms, {}: {:.1e}", runner.route(), apart.max_abs);
            assert!(apart.max_abs < 2e-5, "{}: {apart:?}", runner.route());
        }
    }
}

/// Shaders with one fault are refused, whatever the driver; the sound one passes.
#[test]
fn a_wrong_shader_does_not_pass() {
    let height = relief();
    let variant = Variant {
        wavelengths: Wavelengths { step_nm: 5.0, ..fine(19, 1).wavelengths },
        ..fine(19, 1)
    };
    let placement = Placement { height: &height, rotate_deg: 30.0, variant: &variant };
    let Some(gpu) = found(Gpu::open(Backend::Vulkan, None)) else { return };
    let sound = Prepared::new(placement).unwrap();
    check(&sound, &gpu).unwrap();
    let faults = [
        ("full", "window(place - bin, sharpness)", "0.9 * window(place - bin, sharpness)"),
        ("gain", "turn.x * path.x + turn.y * path.y", "turn.x * path.x - turn.y * path.y"),
        ("bins", "sum.xy + tau * sum.zw", "sum.xy - tau * sum.zw"),
    ];
    for (template, right, wrong) in faults {
        let mut prepared = sound.clone();
        let text = prepared.sources.0.get_mut(template).unwrap();
        assert!(text.contains(right), "{template}");
        *text = text.replace(right, wrong);
        let error = check(&prepared, &gpu).unwrap_err();
        assert!(error.is_finding() && error.to_string().contains("wrong colours"), "{error}");
    }
    // terms that never arrived
    let mut empty = sound.clone();
    empty.terms.texels.fill(0.0);
    let runner = DriverRunner::with(empty, gpu.clone());
    let black =
        runner.tristimulus(&[Directions { wi: direction(0.0, 0.0), wr: direction(0.0, 0.0) }]);
    assert_eq!(black.unwrap(), [[0.0; 3]]);
}

/// Random paths: sound shaders pass on both drivers, each fault is refused.
#[test]
fn wrong_paths_do_not_pass() {
    let height = synthesise(
        &serde_json::from_str(
            r#"{ "kind": "blazed", "period_um": 2.5, "height_um": 0.3, "pixels": 60 }"#,
        )
        .unwrap(),
        "blazed",
    )
    .unwrap()
    .field;
    let optics = Optics {
        coherence: Coherence::Ensemble,
        coherence_scaling: CoherenceScaling::Wavelength,
        ..Optics::standard()
    };
    let variant = |mode, table, sampling| Variant {
        mode,
        table,
        sampling,
        bake_mib: 1.0,
        lights: vec![LightFunction::Direction, LightFunction::Path],
        name: "paths".into(),
        ..Variant::texts(&optics)
    };
    let orders = variant(Mode::Orders, TableFormat::F32, Sampling::Load);
    let baked = variant(Mode::Baked, TableFormat::F32, Sampling::Load);
    let filtered = variant(Mode::Baked, TableFormat::F16, Sampling::Filter);
    let of_orders: [(&str, &str, &str); 6] = [
        ("order_path", "share / chance * light", "share * light"),
        ("order_path", " / textureLoad(paths, vec2i(cell, 2), 0).x", ""),
        ("order_path", "drawn_wavelength(random.z)", "drawn_wavelength(random.x)"),
        ("order_path", "from_surface(wi), lambda_um", "wi, lambda_um"),
        ("order_path", "random.y < pair.x", "random.y > pair.x"),
        ("order_path", "return dot(rgb, mix(", "return dot(rgb.zyx, mix("),
    ];
    let of_baked: [(&str, &str, &str); 4] = [
        ("colour_path", ".xy) * path.z;", ".xy);"),
        ("colour_path", "chance *= select(", "chance = select("),
        ("colour_path", "turn.x * uv.x - turn.y * uv.y", "turn.x * uv.x + turn.y * uv.y"),
        ("colour_path", "RADIANCE_SCALE / chance", "3.1415927 * RADIANCE_SCALE / chance"),
    ];
    let cases: [(&Variant, &[_]); 3] =
        [(&orders, &of_orders), (&baked, &of_baked), (&filtered, &of_baked[..1])];
    for (variant, faults) in cases {
        let placement = Placement { height: &height, rotate_deg: 30.0, variant };
        let sound = Prepared::new(placement).unwrap();
        for backend in [Backend::Vulkan, Backend::Gl] {
            let Some(gpu) = found(Gpu::open(backend, None)) else { continue };
            check(&sound, &gpu).unwrap();
            for (template, right, wrong) in faults {
                let mut prepared = sound.clone();
                let text = prepared.sources.0.get_mut(*template).unwrap();
                assert!(text.contains(right), "{template}: {right}");
                *text = text.replace(right, wrong);
                let error = check(&prepared, &gpu).expect_err(wrong);
                assert!(error.is_finding() && error.to_string().contains("wrong"), "{error}");
            }
        }
    }
}

#[test]
fn the_horizon_is_black_on_every_route() {
    let height = relief();
    let variant = Variant {
        wavelengths: Wavelengths { step_nm: 5.0, ..fine(19, 1).wavelengths },
        ..fine(19, 1)
    };
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let pair = |i: f64, r: f64| Directions { wi: direction(i, 0.0), wr: direction(r, 180.0) };
    let directions = [pair(90.0, 20.0), pair(20.0, 90.0), pair(90.0, 90.0), pair(20.0, 20.0)];
    let mut routes: Vec<Box<dyn Runner + '_>> =
        vec![Box::new(Exact(placement)), Box::new(TwinRunner::new(placement, true).unwrap())];
    for backend in [Backend::Vulkan, Backend::Gl] {
        if let Some(gpu) = found(Gpu::open(backend, None)) {
            routes.push(Box::new(ShaderRunner::new(placement, gpu).unwrap()));
        }
    }
    for route in routes {
        let colours = route.tristimulus(&directions).unwrap();
        assert_eq!(colours[..3], [[0.0; 3]; 3], "{}", route.route());
        assert!(colours[3][1] > 1e-4, "{}: {:?}", route.route(), colours[3]);
    }
}
