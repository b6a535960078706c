//! The shaders on real drivers against their f64 twins, on the same packed tables: arithmetic error alone.

use crate::support::data;
use crate::support::tools::found;
use diffraction_harness::drivers::gpu::{Backend, Gpu};
use diffraction_harness::drivers::{DriverRunner, Prepared, ShaderRunner};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::input;
use diffraction_shaders::optics::colour_difference::{ColourDifference, colour_difference};
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{
    Auto, Basis, Coherence, CoherenceScaling, FileSource, Grating, Level, Mode, Optics, Packing,
    Reconstruction, Sampling, SurfaceOptics, SurfaceSource, SurfaceSpec, TableFormat, Variant,
};
use diffraction_shaders::runner::{Placement, Runner, TwinRunner, rounded};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use diffraction_shaders::variant::CENTRED;

/// The same through the linear filter of a driver that rounds its weights to 8 bits, see the table of tolerances.
const FILTERED: f64 = 3e-3;

/// Greatest arithmetic error of `texts`: 31 terms of a series about the lowest height cancel from `exp(z H)` down to 1, and
/// each is rounded to 24 bits: `exp(z H)·2⁻²⁴` is 2.3e-4 for H = 0.25 µm at z = 33.
fn texts_bound(height: &HeightField) -> f64 {
    let (low_um, high_um) = height.range_um();
    let z_max = diffraction_shaders::tables::basis::max_z(380.0);
    (z_max * (high_um - low_um)).exp() * 2.0_f64.powi(-24)
}

fn adapters() -> Vec<Gpu> {
    [Backend::Vulkan, Backend::Gl].into_iter().filter_map(|b| found(Gpu::open(b, None))).collect()
}

fn standard(terms: u32) -> Variant {
    let texts = Variant::texts(&Optics::standard());
    Variant {
        name: "standard".into(),
        basis: Basis::Taylor,
        terms: Auto::Value(terms),
        packing: Packing::Paired,
        hoist: true,
        ..texts
    }
}

/// Map of `size²` by the shader and by the twin.
fn difference(
    gpu: &Gpu,
    height: &HeightField,
    variant: &Variant,
    rotate_deg: f64,
    theta_i: f64,
    size: usize,
) -> ColourDifference {
    let placement = Placement { height, rotate_deg, variant };
    let light = rounded(direction(theta_i, 10.0));
    let twin = TwinRunner::new(placement, true).unwrap().brdf_map(light, size).unwrap().disc();
    let shader = ShaderRunner::new(placement, gpu.clone()).unwrap();
    let map = shader.brdf_map(light, size).unwrap().disc();
    colour_difference(&format!("{} {}", variant.name, shader.route()), &twin, &map, None).unwrap()
}

/// A table of two pages.
fn baked(table: TableFormat, sampling: Sampling) -> Variant {
    Variant { mode: Mode::Baked, table, sampling, bake_mib: 6.0, bake_error: 1.0, ..standard(1) }
}

fn blazed() -> HeightField {
    synthesise(&Grating::Blazed { period_um: 2.5, height_um: 0.25, pixels: 60 }, "blazed")
        .unwrap()
        .field
}

fn fingers() -> HeightField {
    let text = r#"{ "kind": "fingers", "size_um": 6.6, "pixels": 90, "pitch_um": 1.1, "height_um": 0.3, "seed": 3 }"#;
    synthesise(&serde_json::from_str(text).unwrap(), "fingers").unwrap().field
}

#[test]
fn every_form_of_the_full_mode_agrees_with_its_twin() {
    let (blazed, fingers) = (blazed(), fingers());
    for gpu in adapters() {
        for (packing, hoist) in [
            (Packing::Paired, true),
            (Packing::Single, true),
            (Packing::Paired, false),
            (Packing::Single, false),
        ] {
            let variant = Variant { packing, hoist, ..standard(19) };
            let c = difference(&gpu, &blazed, &variant, 0.0, 20.0, 64);
            assert!(c.max_abs <= CENTRED && c.de2000.p99 <= 0.01, "{packing:?} {hoist}: {c:?}");
        }
        let mut optics = Optics {
            coherence: Coherence::Ensemble,
            coherence_um: 20.0,
            shadowing: false,
            ..Optics::standard()
        };
        let ensemble =
            Variant { optics: optics.clone(), window_radius: Auto::Auto, ..standard(20) };
        optics.coherence = Coherence::Single;
        optics.coherence_scaling = CoherenceScaling::Wavelength;
        let scaling =
            Variant { optics, window_radius: Auto::Value(2), terms: Auto::Auto, ..standard(20) };
        for (variant, rotate_deg) in [(standard(19), 0.0), (ensemble, 30.0), (scaling, -45.0)] {
            let c = difference(&gpu, &fingers, &variant, rotate_deg, 20.0, 64);
            assert!(c.max_abs <= CENTRED && c.de2000.p99 <= 0.01, "{variant:?}: {c:?}");
        }
    }
}

#[test]
fn the_other_modes_and_formats_agree_with_their_twins() {
    let (blazed, fingers) = (blazed(), fingers());
    let ensemble = Optics { coherence: Coherence::Ensemble, ..Optics::standard() };
    let forms = [
        Variant { mode: Mode::Pq, window_radius: Auto::Value(3), ..standard(19) },
        Variant { mode: Mode::Adaptive, ..standard(19) },
        Variant { mode: Mode::Adaptive, optics: ensemble, ..standard(20) },
        Variant { mode: Mode::Gems, ..standard(19) },
        Variant { table: TableFormat::F16, ..standard(19) },
        baked(TableFormat::F32, Sampling::Load),
        baked(TableFormat::Rgb9e5, Sampling::Load),
        baked(TableFormat::Rgb9e5, Sampling::Filter),
        baked(TableFormat::F16, Sampling::Filter),
        Variant {
            table: TableFormat::F16,
            mode: Mode::Adaptive,
            packing: Packing::Single,
            ..standard(19)
        },
    ];
    for gpu in adapters() {
        for variant in &forms {
            for (height, rotate_deg) in [(&blazed, 0.0), (&fingers, 25.0)] {
                let c = difference(&gpu, height, variant, rotate_deg, 20.0, 64);
                let what = format!("{:?} {:?}", variant.mode, variant.table);
                // the last bit of a direction is a small part of a column of the table
                let baked = variant.mode == Mode::Baked;
                let (most, p99) = if baked { (5.0 * CENTRED, 0.02) } else { (CENTRED, 0.01) };
                assert!(c.max_abs <= most && c.de2000.p99 <= p99, "{what}: {c:?}");
            }
        }
    }
}

/// What is read between texels, by four loads and through the filter: both are what the twin reads, and so each other. A
/// filter that takes the nearest texel is not.
#[test]
fn tables_read_between_their_texels_agree_with_their_twins() {
    let (blazed, fingers) = (blazed(), fingers());
    let optics = Optics { coherence_um: 12.0, ..Optics::standard() };
    let prefiltered = |mode, basis, terms, packing, sampling| Variant {
        mode,
        basis,
        packing,
        sampling,
        reconstruction: Reconstruction::Prefiltered,
        table: TableFormat::F16,
        optics: optics.clone(),
        ..standard(terms)
    };
    let forms = [
        (Mode::Adaptive, Basis::Optimal, 5, Packing::Paired),
        (Mode::Adaptive, Basis::Chebyshev, 9, Packing::Single),
        (Mode::Full, Basis::Taylor, 12, Packing::Paired),
    ];
    for gpu in adapters() {
        for (mode, basis, terms, packing) in forms {
            for (height, rotate_deg) in [(&blazed, 0.0), (&fingers, 25.0)] {
                for (sampling, allowed) in [(Sampling::Load, CENTRED), (Sampling::Filter, FILTERED)]
                {
                    let variant = prefiltered(mode, basis, terms, packing, sampling);
                    let c = difference(&gpu, height, &variant, rotate_deg, 20.0, 48);
                    println!("{mode:?} {basis:?} {sampling:?}: {:.1e}", c.max_abs);
                    assert!(c.max_abs <= allowed && c.de2000.p99 <= 0.05, "{variant:?}: {c:?}");
                }
            }
        }
        let variant =
            prefiltered(Mode::Adaptive, Basis::Optimal, 5, Packing::Paired, Sampling::Filter);
        let placement = Placement { height: &fingers, rotate_deg: 0.0, variant: &variant };
        let mut nearest = Prepared::new(placement).unwrap();
        let template = nearest.sources.0.get_mut("prefiltered").unwrap();
        assert!(template.contains("place / size"));
        *template = template.replace("place / size", "floor(place + 0.5) / size");
        let light = rounded(direction(20.0, 10.0));
        let twin = TwinRunner::new(placement, true).unwrap().brdf_map(light, 48).unwrap().disc();
        let wrong = DriverRunner::with(nearest, gpu).brdf_map(light, 48).unwrap().disc();
        assert!(
            colour_difference("nearest", &twin, &wrong, None).unwrap().max_abs > 10.0 * FILTERED
        );
    }
}

#[test]
fn texts_agrees_within_its_own_bound() {
    let height = blazed();
    let bound = texts_bound(&height);
    for gpu in adapters() {
        let c = difference(&gpu, &height, &Variant::texts(&Optics::standard()), 0.0, 20.0, 64);
        assert!(c.max_abs <= bound, "{:e} over {bound:e}", c.max_abs);
    }
}

/// A shader whose light is mirrored, or that lacks its last term but one, must be distinguished from the twin.
#[test]
fn wrong_shaders_are_caught() {
    let height = blazed();
    for gpu in adapters() {
        let right = standard(19);
        let placement = Placement { height: &height, rotate_deg: 0.0, variant: &right };
        let light = rounded(direction(20.0, 0.0));
        let twin = TwinRunner::new(placement, true).unwrap().brdf_map(light, 64).unwrap().disc();
        let mirrored = rounded(direction(20.0, 180.0));
        let wrong = ShaderRunner::new(placement, gpu.clone())
            .unwrap()
            .brdf_map(mirrored, 64)
            .unwrap()
            .disc();
        assert!(
            colour_difference("mirrored", &twin, &wrong, None).unwrap().max_abs > 100.0 * CENTRED
        );
        let fewer = standard(9);
        let placement = Placement { variant: &fewer, ..placement };
        let wrong =
            ShaderRunner::new(placement, gpu.clone()).unwrap().brdf_map(light, 64).unwrap().disc();
        assert!(
            colour_difference("fewer terms", &twin, &wrong, None).unwrap().max_abs > 10.0 * CENTRED
        );
    }
}

/// `probe` and the single-wavelength response, on directions near orders and the mirror.
#[test]
fn listed_directions_agree_too() {
    let height = blazed();
    let variant = standard(19);
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let directions: Vec<Directions> = (0..1000)
        .map(|i| {
            let (wi, theta_r) = (direction(30.0, 0.0), 0.1 * f64::from(i % 650));
            Directions {
                wi: rounded(wi),
                wr: rounded(direction(theta_r, if i < 650 { 180.0 } else { 0.0 })),
            }
        })
        .collect();
    let twin = TwinRunner::new(placement, true).unwrap();
    let colours = twin.tristimulus(&directions).unwrap();
    let responses = twin.response(&directions, 550.0).unwrap();
    assert!(responses.iter().any(|p2| *p2 > 0.1), "no order is met");
    for gpu in adapters() {
        let shader = ShaderRunner::new(placement, gpu).unwrap();
        let c =
            colour_difference("probe", &colours, &shader.tristimulus(&directions).unwrap(), None)
                .unwrap();
        assert!(c.max_abs <= CENTRED && c.de2000.p99 <= 0.01, "{c:?}");
        for (got, want) in shader.response(&directions, 550.0).unwrap().iter().zip(&responses) {
            assert!((got - want).abs() <= CENTRED, "{got} against {want}");
        }
    }
}

#[test]
fn a_measured_scan_agrees_at_two_angles() {
    let Some(path) = data::find("elaphe_65um.png") else { return };
    let source =
        FileSource { path, size_um: Some(65.0), height_um: Some(0.375), ..FileSource::default() };
    let source = SurfaceSource::File(source);
    let spec = SurfaceSpec {
        name: "elaphe".into(),
        source,
        rotate_deg: 0.0,
        level: Level::None,
        clip_percent: 0.0,
        optics: SurfaceOptics::default(),
    };
    let height = input::load_surface(&spec).unwrap().field;
    for gpu in adapters() {
        for theta_i in [0.0, 20.0] {
            let c = difference(&gpu, &height, &standard(19), 0.0, theta_i, 128);
            assert!(c.max_abs <= CENTRED && c.de2000.p99 <= 0.01, "{theta_i}: {c:?}");
        }
        let texts = Variant::texts(&Optics::standard());
        let c = difference(&gpu, &height, &texts, 0.0, 20.0, 64);
        assert!(c.max_abs <= texts_bound(&height), "{c:?}");
    }
}
