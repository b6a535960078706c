//! Synthetic surfaces: formulas, ranges, periodicity, reproducibility, refusals.

use std::f64::consts::{PI, TAU};

use crate::support::heights::assert_says;
use diffraction_shaders::plan::{Grating, Rough};
use diffraction_shaders::surface::synthetic::synthesise;
use diffraction_shaders::surface::{HeightField, Surface};

const KINDS: [fn(Rough) -> Grating; 3] = [Grating::Bumps, Grating::Fingers, Grating::Rows];

fn make(grating: &Grating) -> Surface {
    synthesise(grating, "probe").unwrap()
}

fn rough() -> Rough {
    Rough {
        size_um: 13.2,
        pixels: 264,
        pitch_um: 1.2,
        height_um: 0.3,
        seed: 11,
        regularity: 0.7,
        length_um: None,
    }
}

/// `|c_m|²` of the first row by its definition.
fn power(field: &HeightField, order: i32, z: f64) -> f64 {
    let n = field.columns();
    let (mut re, mut im) = (0.0, 0.0);
    for (col, h) in field.heights_um()[..n].iter().enumerate() {
        let phase = z * h + TAU * f64::from(order) * col as f64 / n as f64;
        re += phase.cos() / n as f64;
        im += phase.sin() / n as f64;
    }
    re * re + im * im
}

fn sinc(t: f64) -> f64 {
    if t.abs() < 1e-12 { 1.0 } else { (PI * t).sin() / (PI * t) }
}

#[test]
fn gratings_are_wide_enough_and_constant_along_y() {
    for grating in [
        Grating::Flat { period_um: 2.5, pixels: 50 },
        Grating::Sinusoidal { period_um: 2.5, height_um: 0.3, pixels: 50 },
        Grating::Blazed { period_um: 2.5, height_um: 0.3, pixels: 50 },
        Grating::Lamellar { period_um: 2.5, height_um: 0.3, pixels: 50, duty: 0.3 },
        Grating::Triangle { period_um: 2.5, height_um: 0.3, pixels: 50, apex: 0.3 },
    ] {
        let Surface { field, notes } = make(&grating);
        assert!(notes.is_empty(), "{notes:?}");
        assert_eq!((field.columns(), field.rows()), (50, 4));
        assert!(
            (field.pitch_x_um() - 0.05).abs() < 1e-15 && field.pitch_x_um() == field.pitch_y_um()
        );
        assert!(field.heights_um().chunks(50).all(|row| row == &field.heights_um()[..50]));
        assert_eq!(field.range_um().0, 0.0);
    }
}

#[test]
fn orders_converge_to_the_closed_forms() {
    let (height_um, period_um, pixels) = (0.3, 2.5, 500);
    let z = -1.9 * TAU / 0.55;
    let close = |name: &str, m: i32, got: f64, wanted: f64| {
        assert!(
            (got.sqrt() - wanted.sqrt()).abs() < 1.0 / pixels as f64,
            "{name} {m}: {got}, not {wanted}"
        );
    };
    let sine = make(&Grating::Sinusoidal { period_um, height_um, pixels }).field;
    let blaze = make(&Grating::Blazed { period_um, height_um, pixels }).field;
    let duty = 0.3;
    let steps = make(&Grating::Lamellar { period_um, height_um, pixels, duty }).field;
    let apex = 0.2;
    let peaks = make(&Grating::Triangle { period_um, height_um, pixels, apex }).field;
    for m in -6..=6 {
        let zh = z * height_um;
        close("sinusoidal", m, power(&sine, m, z), libm::jn(m, zh / 2.0).powi(2));
        close("blazed", m, power(&blaze, m, z), sinc(zh / TAU + f64::from(m)).powi(2));
        let lamellar = match m {
            0 => (1.0 - duty + duty * zh.cos()).powi(2) + (duty * zh.sin()).powi(2),
            _ => (2.0 * (zh / 2.0).sin() * (PI * f64::from(m) * duty).sin() / (PI * f64::from(m)))
                .powi(2),
        };
        close("lamellar", m, power(&steps, m, z), lamellar);
        let part = |share: f64, turn: f64| {
            (
                share * sinc(turn / TAU) * (turn / 2.0).cos(),
                share * sinc(turn / TAU) * (turn / 2.0).sin(),
            )
        };
        let (rise, fall) = (
            part(apex, zh + TAU * f64::from(m) * apex),
            part(1.0 - apex, zh - TAU * f64::from(m) * (1.0 - apex)),
        );
        close(
            "triangle",
            m,
            power(&peaks, m, z),
            (rise.0 + fall.0).powi(2) + (rise.1 + fall.1).powi(2),
        );
    }
}

#[test]
fn a_blaze_rises_to_the_right_and_an_apex_is_where_it_was_put() {
    let blaze = make(&Grating::Blazed { period_um: 2.0, height_um: 0.4, pixels: 40 }).field;
    assert!(blaze.heights_um()[..40].windows(2).all(|w| w[0] < w[1]));
    assert!((blaze.heights_um()[39] - 0.4 * 39.0 / 40.0).abs() < 1e-15);
    let peaks =
        make(&Grating::Triangle { period_um: 2.0, height_um: 0.4, pixels: 40, apex: 0.25 }).field;
    assert_eq!(peaks.heights_um()[10], 0.4);
    assert!((peaks.heights_um()[25] - 0.2).abs() < 1e-12);
}

#[test]
fn a_duty_that_is_no_whole_number_of_pixels_is_rounded_and_noted() {
    let high = |duty: f64, pixels: usize| {
        let Surface { field, notes } =
            make(&Grating::Lamellar { period_um: 1.0, height_um: 0.1, pixels, duty });
        (field.heights_um()[..pixels].iter().filter(|h| **h > 0.0).count(), notes.len())
    };
    assert_eq!(high(0.3, 100), (30, 0));
    assert_eq!(high(0.07, 100), (7, 0));
    assert_eq!(high(1.0 / 3.0, 100), (33, 1));
    assert_eq!(high(0.001, 100), (1, 1));
    assert_eq!(high(0.999, 100), (99, 1));
    assert_eq!(high(0.5, 2), (1, 0));
}

#[test]
fn crossed_gratings_add_and_keep_their_own_pitches() {
    let x = Grating::Blazed { period_um: 2.0, height_um: 0.2, pixels: 40 };
    let y = Grating::Blazed { period_um: 3.0, height_um: 0.1, pixels: 50 };
    let field = make(&Grating::Crossed { x: Box::new(x.clone()), y: Box::new(y) }).field;
    assert_eq!((field.columns(), field.rows()), (40, 50));
    assert!((field.pitch_x_um() - 0.05).abs() < 1e-15 && (field.pitch_y_um() - 0.06).abs() < 1e-15);
    // y grows upwards: the bottom left corner is the lowest, the top right the highest
    assert_eq!(field.heights_um()[49 * 40], 0.0);
    let highest = 0.2 * 39.0 / 40.0 + 0.1 * 49.0 / 50.0;
    assert!((field.heights_um()[39] - highest).abs() < 1e-12);
    let nested = Grating::Crossed { x: Box::new(Grating::Bumps(rough())), y: Box::new(x.clone()) };
    assert_says(synthesise(&nested, "probe"), &["along x", "random"]);
    let crossed = Grating::Crossed { x: Box::new(x.clone()), y: Box::new(x.clone()) };
    let twice = Grating::Crossed { x: Box::new(x), y: Box::new(crossed) };
    assert_says(synthesise(&twice, "probe"), &["along y", "crossed"]);
}

#[test]
fn random_surfaces_span_exactly_their_height() {
    for kind in KINDS {
        for regularity in [0.0, 0.7, 1.0] {
            let field = make(&kind(Rough { regularity, ..rough() })).field;
            assert_eq!((field.columns(), field.rows()), (264, 264));
            assert_eq!(field.range_um(), (0.0, 0.3));
        }
    }
}

/// The step across the seam is like the steps inside: as a share of pixels with a large step, along both axes.
#[test]
fn random_surfaces_tile() {
    for kind in KINDS {
        let field = make(&kind(rough())).field;
        let (n, h) = (field.columns(), field.heights_um());
        let mean = |step: &dyn Fn(usize) -> f64| (0..n).map(step).sum::<f64>() / n as f64;
        let across = |col: usize| mean(&|r| (h[r * n + (col + 1) % n] - h[r * n + col]).abs());
        let down = |row: usize| mean(&|c| (h[(row + 1) % n * n + c] - h[row * n + c]).abs());
        let most = |line: &dyn Fn(usize) -> f64| (0..n - 1).map(line).fold(0.0, f64::max);
        assert!(across(n - 1) <= 1.1 * most(&across), "{} {}", across(n - 1), most(&across));
        assert!(down(n - 1) <= 1.1 * most(&down), "{} {}", down(n - 1), most(&down));
    }
}

/// A perfect lattice repeats after one feature, so its period can be read off.
#[test]
fn regular_surfaces_have_the_pitch_they_were_given() {
    for kind in KINDS {
        let field = make(&kind(Rough { regularity: 1.0, length_um: Some(1.1), ..rough() })).field;
        let (n, h) = (field.columns(), field.heights_um());
        // 13.2 µm hold 11 features of 1.2 µm, 24 pixels each
        let differs = |shift: usize| {
            (0..n)
                .map(|c| (h[100 * n + c] - h[100 * n + (c + shift) % n]).abs())
                .fold(0.0, f64::max)
        };
        // the furrows of `rows` start anywhere along y, so there only the ridges repeat
        let same = if matches!(kind(rough()), Grating::Rows(_)) { 0.15 } else { 1e-9 };
        assert!(differs(24) < same, "{}", differs(24));
        assert!(differs(12) > 0.0);
    }
}

#[test]
fn seeds_decide_and_nothing_else_does() {
    for kind in KINDS {
        let first = make(&kind(rough())).field;
        assert_eq!(first, make(&kind(rough())).field);
        let other = make(&kind(Rough { seed: 12, ..rough() })).field;
        let apart = first
            .heights_um()
            .iter()
            .zip(other.heights_um())
            .filter(|(a, b)| (*a - *b).abs() > 0.01)
            .count();
        assert!(apart > 264 * 264 / 10, "{apart}");
        // more pixels are the same surface, sampled more finely
        let fine = make(&kind(Rough { pixels: 528, ..rough() })).field;
        let close = (0..264 * 264)
            .filter(|&i| {
                let (col, row) = (i % 264, i / 264);
                (first.heights_um()[i] - fine.heights_um()[(2 * row + 1) * 528 + 2 * col]).abs()
                    < 0.02
            })
            .count();
        assert!(close > 264 * 264 * 95 / 100, "{close}");
    }
}

/// The same numbers on every platform, and in every version unless the changelog says otherwise.
#[test]
fn heights_are_pinned() {
    let wanted = [
        [0.111454018215, 0.0, 0.273758252811],
        [0.131171608215, 0.045779238980, 0.080063012833],
        [0.130656263154, 0.299113808947, 0.299188979731],
    ];
    for (kind, wanted) in KINDS.iter().zip(wanted) {
        let field = make(&kind(rough())).field;
        for (at, wanted) in [1000, 30_000, 60_000].into_iter().zip(wanted) {
            let h = field.heights_um()[at];
            assert!((h - wanted).abs() < 1e-9, "{at}: {h:.12}, not {wanted}");
        }
    }
}

#[test]
fn spacings_that_do_not_fit_are_adjusted_and_noted() {
    let surface = make(&Grating::Rows(Rough { pitch_um: 1.55, ..rough() }));
    assert!(
        surface.notes.iter().any(|n| n.contains("pitch_um = 1.55") && n.contains("1.4667")),
        "{:?}",
        surface.notes
    );
}

#[test]
fn bad_keys_are_named() {
    let sine = |period_um: f64, height_um: f64, pixels: usize| {
        synthesise(&Grating::Sinusoidal { period_um, height_um, pixels }, "probe")
    };
    for bad in [0.0, -2.0, f64::NAN, f64::INFINITY] {
        assert_says(sine(bad, 0.3, 50), &["probe", "period_um"]);
        assert_says(sine(2.5, bad, 50), &["probe", "height_um"]);
    }
    assert_says(sine(2.5, 300.0, 50), &["height_um = 300", "nm"]);
    assert_says(sine(2.5e6, 0.3, 50), &["period_um = 2500000", "nm"]);
    assert_says(sine(2.5, 0.3, 1), &["pixels = 1", "2 to"]);
    assert_says(sine(2.5, 0.3, usize::MAX), &["pixels", "16384"]);
    for bad in [0.0, 1.0, -0.5, f64::NAN] {
        let (period_um, height_um, pixels) = (2.5, 0.3, 50);
        assert_says(
            synthesise(&Grating::Lamellar { period_um, height_um, pixels, duty: bad }, "probe"),
            &["duty"],
        );
        assert_says(
            synthesise(&Grating::Triangle { period_um, height_um, pixels, apex: bad }, "probe"),
            &["apex"],
        );
    }
    let bumps = |rough: Rough| synthesise(&Grating::Bumps(rough), "probe");
    assert_says(bumps(Rough { regularity: 1.5, ..rough() }), &["regularity = 1.5"]);
    assert_says(bumps(Rough { pitch_um: 40.0, ..rough() }), &["pitch_um = 40", "size_um"]);
    assert_says(bumps(Rough { pitch_um: 0.1, ..rough() }), &["pitch_um = 0.1", "four pixels"]);
    assert_says(bumps(Rough { length_um: Some(-1.0), ..rough() }), &["length_um = -1"]);
    assert_says(bumps(Rough { pixels: 10_000, ..rough() }), &["10000 × 10000", "limit"]);
    assert_says(bumps(Rough { size_um: f64::NAN, ..rough() }), &["size_um"]);
}

#[test]
fn shape_keys_have_defaults() {
    let text = r#"kind = "fingers"
size_um = 13.2
pixels = 264
pitch_um = 1.2
height_um = 0.3
seed = 11"#;
    assert_eq!(toml::from_str::<Grating>(text).unwrap(), Grating::Fingers(rough()));
    let all = format!("{text}\nregularity = 0.5\nlength_um = 3.0");
    let wanted = Rough { regularity: 0.5, length_um: Some(3.0), ..rough() };
    assert_eq!(toml::from_str::<Grating>(&all).unwrap(), Grating::Fingers(wanted));
    assert!(toml::from_str::<Grating>(&format!("{text}\nregularty = 0.5")).is_err());
}
