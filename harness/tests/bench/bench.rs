//! Benchmarks on the software drivers: that they measure, not how fast anything is.

use crate::support::tools;
use std::time::Duration;

use diffraction_harness::bench::clock::SystemClock;
use diffraction_harness::bench::driver::{Case, Group, Scene, Under, measure};
use diffraction_harness::bench::result::{Place, bench};
use diffraction_harness::bench::rounds::Rules;
use diffraction_harness::bench::yardstick::Yardstick;
use diffraction_harness::drivers::gpu::{Backend, Gpu};
use diffraction_harness::results::Bench;
use diffraction_shaders::light::Studio;
use diffraction_shaders::plan::{
    Auto, Coherence, CoherenceScaling, Mode, Optics, Variant, Wavelengths,
};
use diffraction_shaders::surface::HeightField;

const SIZE: usize = 8;

/// Runs `test` on both backends. A missing driver is a failure where the tools are required, else it is said.
fn on_both(test: impl Fn(&Gpu)) {
    for backend in [Backend::Vulkan, Backend::Gl] {
        if let Some(gpu) = tools::found(Gpu::open(backend, None)) {
            test(&gpu);
        }
    }
}

/// A small blazed grating.
fn grating(columns: usize) -> HeightField {
    let heights = (0..columns).map(|i| 0.3 * i as f64 / columns as f64).collect::<Vec<_>>();
    let heights = [heights.clone(), heights].concat();
    HeightField::new(columns, 2, 2.5 / columns as f64, 0.05, heights).expect("valid")
}

fn small(name: &str, terms: u32) -> Case {
    let variant = Variant {
        name: name.to_owned(),
        terms: Auto::Value(terms),
        wavelengths: Wavelengths { min_nm: 400.0, max_nm: 700.0, step_nm: 100.0 },
        ..Variant::texts(&Optics::standard())
    };
    Case::Map {
        variant: Box::new(variant),
        height: None,
        frame: [SIZE; 2],
        under: Under::Direction,
    }
}

fn run(gpu: &Gpu, height: &HeightField, cases: &[Case]) -> Group {
    let scene = Scene { height, rotate_deg: 30.0, light: [20.0, 0.0], unchecked: false };
    let rules = Rules::standard(Duration::ZERO);
    measure(gpu, &scene, cases, &SystemClock::new(), &rules, &|_| (), &|| false)
}

#[test]
fn records_hold_what_was_measured() {
    on_both(|gpu| {
        let yardstick = |what| {
            let optics = Box::new(Optics::standard());
            Case::Yardstick { what, optics, frame: [SIZE; 2] }
        };
        let cases = [
            small("long", 12),
            small("short", 2),
            yardstick(Yardstick::Empty),
            yardstick(Yardstick::Ggx),
        ];
        let group = run(gpu, &grating(40), &cases);
        let timed: Vec<_> =
            group.cases.iter().map(|case| case.as_ref().expect("measured")).collect();
        let place = Place {
            surface: "blazed".into(),
            backend: gpu.info().backend.name().into(),
            adapter: gpu.info().name.clone(),
            light: [20.0, 0.0],
        };
        let records: Vec<Bench> = timed
            .iter()
            .map(|case| bench(&place, group.timing, case, Some(timed[0])).expect("rounds"))
            .collect();
        let names: Vec<&str> = records.iter().map(|r| r.variant.as_str()).collect();
        assert_eq!(names, ["long", "short", "empty", "ggx"]);
        for record in &records {
            let [low, high] = record.interval_ms;
            assert!(0.0 < low && low <= record.median_ms && record.median_ms <= high, "{record:?}");
            assert!(record.pipeline_ms > 0.0 && record.cpu_ms >= 0.0, "{record:?}");
            assert!(record.ratio.is_some_and(|ratio| ratio > 0.0), "{record:?}");
            assert_eq!((record.runs, record.size), (6, SIZE));
            assert!((1..=20).contains(&record.frames_per_run), "{record:?}");
            assert_eq!(record.baseline.as_deref(), Some("long"));
        }
        assert_eq!(records[0].ratio_interval, Some([1.0; 2]), "the baseline against itself");
        // the tables: 31 bins and more, 8 bytes a term; and nothing to read where nothing is computed
        assert!(records[0].table_bytes > records[1].table_bytes && records[2].table_bytes == 0);
        assert_eq!(timed[1].fetches, 4.0 * (9.0 * 2.0 + 1.0));
        assert_eq!((timed[2].fetches, records[2].settings.is_null()), (0.0, true));
        assert!(records[0].settings["mode"] == "full", "{}", records[0].settings);
    });
}

/// The surroundings are looked up as often as counted, and an ordinary material looks once.
#[test]
fn a_studio_is_timed_by_look_ups() {
    on_both(|gpu| {
        let mut optics = Optics::standard();
        optics.coherence = Coherence::Ensemble;
        optics.coherence_scaling = CoherenceScaling::Wavelength;
        let variant =
            Variant { mode: Mode::Orders, name: "orders".into(), ..Variant::texts(&optics) };
        let lit = |under| {
            let variant = Box::new(variant.clone());
            Case::Map { variant, height: None, frame: [SIZE; 2], under }
        };
        let cases = [
            lit(Under::Direction),
            lit(Under::Studio(Studio::Softboxes)),
            lit(Under::GgxIn(Studio::Softboxes)),
        ];
        let names = cases.each_ref().map(Case::name);
        assert_eq!(names, ["orders", "orders (softboxes)", "ggx (softboxes)"]);
        let group = run(gpu, &grating(40), &cases);
        let found = group.cases.iter().map(|case| case.as_ref().expect("measured").lookups);
        let found: Vec<Option<f64>> = found.collect();
        assert!(found[0].is_none() && found[1].is_some_and(|count| count > 20.0), "{found:?}");
        assert_eq!(found[2], Some(1.0));
    });
}

#[test]
fn what_does_not_build_is_an_error_and_the_rest_is_measured() {
    on_both(|gpu| {
        let flat = HeightField::new(40, 2, 0.05, 0.05, vec![0.0; 80]).expect("valid");
        // a flat surface has no period
        let gems = Variant {
            name: "gems".into(),
            mode: Mode::Gems,
            ..Variant::texts(&Optics::standard())
        };
        let gems = Case::Map {
            variant: Box::new(gems),
            height: None,
            frame: [SIZE; 2],
            under: Under::Direction,
        };
        let too_large = match small("large", 2) {
            Case::Map { variant, height, .. } => {
                Case::Map { variant, height, frame: [1_000_000; 2], under: Under::Direction }
            }
            other => other,
        };
        let group = run(gpu, &flat, &[gems, small("good", 2), too_large]);
        let words =
            |index: usize| group.cases[index].as_ref().expect_err("cannot be measured").to_string();
        assert!(words(0).contains("a flat surface has no period"), "{}", words(0));
        assert!(words(2).contains("max_texture_dimension_2d"), "{}", words(2));
        let good = group.cases[1].as_ref().expect("measured, though its baseline is not");
        assert_eq!(good.samples.time_ms.len(), 6);
    });
}
