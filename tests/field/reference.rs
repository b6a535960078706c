//! The reference colours: step of the wavelength integral, twin against reference, and the faults of the older texts.

use std::f64::consts::{PI, TAU};

use diffraction_shaders::field::Scratch;
use diffraction_shaders::field::reference::{Directions, Reference};
use diffraction_shaders::optics::brdf_map::view_directions;
use diffraction_shaders::optics::colour_difference::colour_difference;
use diffraction_shaders::optics::spectrum::Spectrum;
use diffraction_shaders::optics::{Matter, direction};
use diffraction_shaders::plan::{
    Auto, Basis, CoherenceScaling, Grating, Optics, Packing, Reconstruction, Sampling, Variant,
    Wavelengths,
};
use diffraction_shaders::runner::{Exact, Placement, Runner, TwinRunner};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use glam::DVec3;

const PERIOD_UM: f64 = 2.5;
const HEIGHT_UM: f64 = 0.25;

fn blazed() -> HeightField {
    let grating = Grating::Blazed { period_um: PERIOD_UM, height_um: HEIGHT_UM, pixels: 100 };
    synthesise(&grating, "blazed").unwrap().field
}

fn fingers() -> HeightField {
    let text = r#"{ "kind": "fingers", "size_um": 8.8, "pixels": 120, "pitch_um": 1.1, "height_um": 0.3, "seed": 5 }"#;
    synthesise(&serde_json::from_str(text).unwrap(), "fingers").unwrap().field
}

/// The wavelength integral with one step for all directions, nm.
fn uniform(
    height: &HeightField,
    optics: &Optics,
    directions: &[Directions],
    step_nm: f64,
) -> Vec<[f64; 3]> {
    let all = directions.iter().copied();
    let reference = Reference::new(height, 0.0, optics, Reference::VISIBLE_NM, all).unwrap();
    let samples = Spectrum::new(&"D65".into()).unwrap().samples(&Wavelengths {
        min_nm: 380.0,
        max_nm: 780.0,
        step_nm,
    });
    let mut scratch = Scratch::default();
    let mut colour = |d: &Directions| {
        let c = Matter::new(optics).unwrap().gain(d.wi, d.wr, 550.0);
        samples.iter().fold([0.0; 3], |sum: [f64; 3], node| {
            let response = c * reference.response(*d, node.lambda_nm, &mut scratch);
            std::array::from_fn(|i| sum[i] + node.xyz[i] * response)
        })
    };
    directions.iter().map(&mut colour).collect()
}

/// Odd sizes have a row on the plane of incidence, where the orders of a grating along x lie.
fn map(theta_i: f64, size: usize) -> Vec<Directions> {
    let wi = direction(theta_i, 0.0);
    view_directions(size).into_iter().map(|wr| Directions { wi, wr }).collect()
}

fn full(terms: u32, radius: u32, step_nm: f64) -> Variant {
    Variant {
        name: "full".into(),
        basis: Basis::Taylor,
        terms: Auto::Value(terms),
        window_radius: Auto::Value(radius),
        wavelengths: Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm },
        packing: Packing::Paired,
        reconstruction: Reconstruction::Window,
        sampling: Sampling::Load,
        hoist: true,
        ..Variant::texts(&Optics::standard())
    }
}

/// An eighth of the wavelength step changes nothing that could be seen: 1e-4 of the greatest value, CIEDE2000 0.02 in the
/// 99th percentile. What is left comes from the kinks of the colour tables at whole nm. Five times the step does show.
#[test]
fn finer_steps_change_nothing() {
    for (height, scaling) in [
        (blazed(), CoherenceScaling::Fixed),
        (fingers(), CoherenceScaling::Fixed),
        (fingers(), CoherenceScaling::Wavelength),
    ] {
        let optics = Optics { coherence_scaling: scaling, ..Optics::standard() };
        for theta_i in [20.0, 75.0] {
            let directions = map(theta_i, 33);
            let at = |step_nm: f64| {
                Reference::new(
                    &height,
                    0.0,
                    &optics,
                    Reference::VISIBLE_NM,
                    directions.iter().copied(),
                )
                .unwrap()
                .with_coarsest_step_nm(step_nm)
                .tristimulus_all(&directions)
            };
            let (standard, finer) = (at(1.0), at(0.125));
            let c = colour_difference("finer", &standard, &finer, None).unwrap();
            let coarse = colour_difference(
                "coarser",
                &finer,
                &uniform(&height, &optics, &directions, 5.0),
                None,
            )
            .unwrap();
            assert!(coarse.de2000.p95 > 0.2, "{theta_i}°: {coarse:?}");
            assert!(c.max_abs < 2e-4 && c.de2000.p99 < 0.04, "{theta_i}°: {c:?}");
        }
    }
}

/// A window three times as long has lobes three times as narrow; the step follows.
#[test]
fn the_step_follows_the_coherence_length() {
    let height = blazed();
    let optics = Optics { coherence_um: 400.0, ..Optics::standard() };
    let directions = map(20.0, 25);
    let at = |step_nm: f64| {
        Reference::new(&height, 0.0, &optics, Reference::VISIBLE_NM, directions.iter().copied())
            .unwrap()
            .with_coarsest_step_nm(step_nm)
            .tristimulus_all(&directions)
    };
    let finest = at(0.03125);
    let distance =
        |other: &[[f64; 3]]| colour_difference("step", &finest, other, None).unwrap().max_abs;
    assert!(distance(&at(1.0)) < 1e-4, "{:e}", distance(&at(1.0)));
    let fixed = uniform(&height, &optics, &directions, 1.0);
    assert!(distance(&fixed) > 5e-4, "1 nm for all: {:e}", distance(&fixed));
}

/// The twin with enough terms, a wide enough window and fine steps is the reference.
#[test]
fn the_twin_converges_to_the_reference() {
    for height in [blazed(), fingers()] {
        let directions = map(20.0, 33);
        let distance = |variant: &Variant| {
            let placement = Placement { height: &height, rotate_deg: 15.0, variant };
            let exact = Exact(placement).tristimulus(&directions).unwrap();
            let twin = TwinRunner::new(placement, false).unwrap().tristimulus(&directions).unwrap();
            colour_difference("twin", &exact, &twin, None).unwrap()
        };
        let fine = distance(&full(30, 3, 0.5));
        assert!(fine.max_abs < 1e-4 && fine.de2000.p99 < 0.01, "{fine:?}");
        // each approximation on its own shows
        assert!(distance(&full(8, 3, 0.5)).de2000.p95 > 1.0, "terms");
        assert!(distance(&full(30, 3, 10.0)).de2000.p95 > 1.0, "wavelengths");
    }
}

/// The texts print the sum of the terms' intensities; amplitudes add. With intensities a mirror already shines.
#[test]
fn amplitudes_of_terms_are_summed_not_intensities() {
    let z: f64 = -20.0;
    let x = z * HEIGHT_UM / 2.0;
    // of the zero order of a flat surface at height H/2 above the origin: |Σ (ix)^n/n!|² = 1
    let terms: Vec<f64> = (0..30)
        .scan(1.0, |t, n| {
            let now = *t;
            *t *= x / f64::from(n + 1);
            Some(now)
        })
        .collect();
    let intensities: f64 = terms.iter().map(|t| t * t).sum();
    assert!(intensities > 5.0, "{intensities}");
    let flat = HeightField::new(4, 4, 0.05, 0.05, vec![HEIGHT_UM / 2.0; 16]).unwrap();
    let variant = Variant { basis: Basis::TaylorZero, ..full(30, 1, 5.0) };
    let placement = Placement { height: &flat, rotate_deg: 0.0, variant: &variant };
    let up = [Directions { wi: DVec3::Z, wr: DVec3::Z }];
    let response = TwinRunner::new(placement, true).unwrap().response(&up, 550.0).unwrap()[0];
    assert!((response - 1.0).abs() < 1e-6, "{response}");
}

/// Sampling uniformly in 1/λ needs `dλ = λ² d(1/λ)`; without it white turns blue and purple.
#[test]
fn wavenumber_sampling_needs_its_jacobian() {
    let spectrum = Spectrum::new(&"D65".into()).unwrap();
    let nodes = 4000;
    let (low, high) = (1.0 / 780.0, 1.0 / 380.0);
    let step = (high - low) / f64::from(nodes);
    let sum = |jacobian: bool| {
        (0..nodes).fold([0.0; 3], |sum: [f64; 3], i| {
            let lambda_nm = 1.0 / (low + (f64::from(i) + 0.5) * step);
            let d_lambda =
                if jacobian { lambda_nm * lambda_nm * step } else { 400.0 / f64::from(nodes) };
            std::array::from_fn(|c| sum[c] + spectrum.per_nm(lambda_nm)[c] * d_lambda)
        })
    };
    let white = spectrum.white();
    let [right, wrong] = [true, false].map(sum);
    assert!((0..3).all(|c| (right[c] - white[c]).abs() < 1e-4), "{right:?}");
    assert!(wrong[2] / wrong[1] > 1.3 * white[2] / white[1], "{wrong:?}");
}

/// The mirror direction is nothing special: it shows the zero order's own efficiency, coloured, not a white disc.
#[test]
fn the_mirror_direction_shows_the_zero_order() {
    let height = blazed();
    let d = Directions { wi: direction(20.0, 0.0), wr: direction(20.0, 180.0) };
    let optics = Optics::standard();
    let reference = Reference::new(&height, 0.0, &optics, Reference::VISIBLE_NM, [d]).unwrap();
    let got = reference.tristimulus(d, &mut Scratch::default());
    let spectrum = Spectrum::new(&"D65".into()).unwrap();
    let closed = (380..=780).fold([0.0; 3], |sum: [f64; 3], nm| {
        let z = TAU / (f64::from(nm) * 1e-3) * (d.wi.z + d.wr.z);
        // the sampled ramp: a geometric sum
        let (n, x) = (100.0, z * HEIGHT_UM / 2.0);
        let efficiency = (x.sin() / (n * (x / n).sin())).powi(2);
        std::array::from_fn(|c| sum[c] + spectrum.per_nm(f64::from(nm))[c] * efficiency)
    });
    let c = Matter::new(&optics).unwrap().gain(d.wi, d.wr, 550.0);
    for (got, closed) in got.iter().zip(closed) {
        assert!((got - c * closed).abs() < 1e-4, "{got} against {}", c * closed);
    }
    let white = spectrum.white();
    assert!((got[2] / got[1] / white[2] - 1.0).abs() > 0.2, "coloured");
    assert!(got[1] < 0.2, "most light goes into the first order");
}

/// Without the stray π in the window's exponent a mirror's lobe has standard deviation `λ/(2π σs)` in u.
#[test]
fn the_window_has_no_stray_factor() {
    let flat = HeightField::new(4, 4, 0.05, 0.05, vec![0.0; 16]).unwrap();
    let sigma_u = 0.55 / (TAU * 65.0 / 4.0);
    let wi = DVec3::Z;
    let x = -sigma_u;
    let d = Directions { wi, wr: DVec3::new(x, 0.0, (1.0 - x * x).sqrt()) };
    let reference =
        Reference::new(&flat, 0.0, &Optics::standard(), Reference::VISIBLE_NM, [d]).unwrap();
    let got = reference.response(d, 550.0, &mut Scratch::default());
    assert!((got - (-1.0_f64).exp()).abs() < 1e-9, "{got}");
    assert!((got - (-PI).exp()).abs() > 0.1);
}
