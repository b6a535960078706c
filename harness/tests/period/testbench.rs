//! The period estimate: against the same estimator on closed forms, for what it is worth, and what it must refuse.

use crate::support::data;
use std::path::Path;

use diffraction_harness::period::{self, ClosedForm, HeatmapText, Lobe, Measurement, Protocol};
use diffraction_shaders::input::load_surface as load;
use diffraction_shaders::optics::{Matter, window_sigma_um};
use diffraction_shaders::plan::{Grating, Mode, Optics, Plan, Variant, Wavelengths};
use diffraction_shaders::runner::{Placement, Runner, TwinRunner};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::facts::facts;
use diffraction_shaders::surface::synthetic::synthesise;

/// What the estimate may be off the one on the closed form, nm.
const CLOSED_NM: f64 = 0.02;
/// The same off the grating equation, nm: the efficiency pulls.
const GRATING_NM: f64 = 0.5;

fn variant(keys: &str) -> Variant {
    let text = format!(
        r#"schema = 1
[[surface]]
name = "a"
grating = {{ kind = "flat", period_um = 2.5, pixels = 100 }}
[variants]
terms = "auto"
term_error = 1e-6
{keys}
"#
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap_or_else(|e| panic!("{keys}: {e}"));
    plan.variants[0].clone()
}

/// The protocol of the texts.
fn protocol(expected_um: f64) -> Protocol {
    let wavelengths = Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm: 5.0 };
    Protocol { theta_i_deg: 75.0, phi_i_deg: 0.0, wavelengths, expected_um, whole: false }
}

fn height(grating: &Grating) -> HeightField {
    synthesise(grating, "grating").unwrap().field
}

fn blazed(height_um: f64, pixels: usize) -> Grating {
    Grating::Blazed { period_um: 2.5, height_um, pixels }
}

/// Gratings whose first orders are far from and near the mirror direction, strong and weak, with their periods, µm.
fn gratings(pixels: usize) -> [(Grating, f64); 5] {
    [
        (blazed(0.25, pixels), 2.5),
        (blazed(0.3, pixels), 2.5),
        (Grating::Sinusoidal { period_um: 1.6, height_um: 0.12, pixels }, 1.6),
        (Grating::Lamellar { period_um: 1.0, height_um: 0.15, pixels, duty: 0.4 }, 1.0),
        (Grating::Triangle { period_um: 2.0, height_um: 0.3, pixels, apex: 0.3 }, 2.0),
    ]
}

fn by_twin(height: &HeightField, variant: &Variant, protocol: Protocol) -> Measurement {
    turned(height, 0.0, variant, protocol)
}

fn turned(h: &HeightField, rotate_deg: f64, variant: &Variant, protocol: Protocol) -> Measurement {
    let placement = Placement { height: h, rotate_deg, variant };
    let twin = TwinRunner::new(placement, true).unwrap();
    let extent_um = period::extent_um(placement, 780.0).unwrap();
    period::measure(&protocol, extent_um, period::runner(&twin, protocol)).unwrap()
}

fn exactly(height: &HeightField, protocol: Protocol) -> Measurement {
    let variant = Variant::texts(&Optics::standard());
    let placement = Placement { height, rotate_deg: 0.0, variant: &variant };
    period::measure(&protocol, 65.0, period::exact(placement, protocol).unwrap()).unwrap()
}

fn closed(grating: &Grating, variant: &Variant, protocol: Protocol) -> Measurement {
    let height = height(grating);
    let placement = Placement { height: &height, rotate_deg: 0.0, variant };
    period::yardstick(grating, placement, &protocol).unwrap().unwrap()
}

/// Greater of the differences of mean and standard deviation, nm.
fn apart(a: &Measurement, b: &Measurement) -> f64 {
    assert_eq!((a.points, a.evanescent, a.flat), (b.points, b.evanescent, b.flat));
    (a.period_nm - b.period_nm).abs().max((a.sd_nm - b.sd_nm).abs())
}

#[test]
fn windowed_modes_meet_the_closed_form_and_the_grating_equation() {
    for (grating, period_um) in gratings(100) {
        let (height, protocol) = (height(&grating), protocol(period_um));
        let full = variant("mode = \"full\"");
        let closed = closed(&grating, &full, protocol);
        let adaptive = by_twin(&height, &variant("mode = \"adaptive\""), protocol);
        let found = [exactly(&height, protocol), by_twin(&height, &full, protocol), adaptive];
        for (found, mode) in found.iter().zip(["exact", "full", "adaptive"]) {
            println!("{grating:?} {mode}: {:.4}, {:.4}", found.period_nm, found.sd_nm);
            assert_eq!(found.points, 81);
            let error = apart(found, &closed);
            assert!(error < CLOSED_NM, "{grating:?} {mode}: {error}");
            let off = found.period_nm - 1e3 * period_um;
            assert!(off.abs() < GRATING_NM, "{grating:?} {mode}: {off}");
        }
    }
}

/// From all bins of a cell. Sharp ends see where a cell begins, and samples begin half a pixel early: hence more pixels.
#[test]
fn replicas_meet_their_own_closed_form_and_many_of_them_the_grating_equation() {
    let sparse = Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm: 20.0 };
    for (grating, period_um) in gratings(128) {
        let height = height(&grating);
        let protocol = Protocol { wavelengths: sparse, ..protocol(period_um) };
        for (periods, is_near) in [("", false), ("periods = [78, 650]", true)] {
            let keys = format!("mode = \"pq\"\nwindow_radius = 64\n{periods}");
            let pq = variant(&keys);
            let found = by_twin(&height, &pq, protocol);
            let error = apart(&found, &closed(&grating, &pq, protocol));
            println!("{grating:?} {periods}: {:.4}, {:.4}", found.period_nm, found.sd_nm);
            assert!(error < CLOSED_NM, "{grating:?} {periods}: {error}");
            let off = found.period_nm - 1e3 * period_um;
            assert!(!is_near || off.abs() < GRATING_NM, "{grating:?} {periods}: {off}");
        }
    }
}

/// The stated figures of the protocol, nm, and that a staircase of the coarsest pitch for 380 nm does not move them.
#[test]
fn blazed_gratings_have_the_stated_periods() {
    for (height_um, mean, sd) in [(0.25, 2499.985, 0.108), (0.3, 2500.15, 0.177)] {
        for pixels in [28, 100] {
            let found = exactly(&height(&blazed(height_um, pixels)), protocol(2.5));
            assert!((found.period_nm - mean).abs() < 0.005, "{pixels}: {}", found.period_nm);
            assert!((found.sd_nm - sd).abs() < 0.005, "{pixels}: {}", found.sd_nm);
        }
    }
}

/// A few samples find what every point of the grid finds, on lobes that overlap too.
#[test]
fn the_grid_need_not_be_filled() {
    let rough = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "fingers", size_um = 24.2, pixels = 400, pitch_um = 1.1, height_um = 0.3, seed = 1 }
"#;
    let plan = Plan::parse(rough, Path::new("plan.toml")).unwrap();
    let rough = load(&plan.surfaces[0]).unwrap().field;
    let sparse = Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm: 40.0 };
    for (surface, period_um) in [(rough, 1.1), (height(&blazed(0.3, 100)), 2.5)] {
        let protocol = Protocol { wavelengths: sparse, ..protocol(period_um) };
        for keys in ["mode = \"full\"\nwindow_radius = 3", "mode = \"pq\""] {
            let variant = variant(keys);
            let placement = Placement { height: &surface, rotate_deg: 0.0, variant: &variant };
            let twin = TwinRunner::new(placement, true).unwrap();
            let with = |extent_um: f64| {
                period::measure(&protocol, extent_um, period::runner(&twin, protocol)).unwrap()
            };
            let few = with(period::extent_um(placement, 780.0).unwrap());
            let all = with(1e9);
            assert!(4 * few.evaluations < all.evaluations, "{keys}: {}", few.evaluations);
            for (few, all) in few.rows.iter().zip(&all.rows) {
                assert!(few.peak.is_some() && few.peak == all.peak, "{keys}: {}", few.lambda_nm);
            }
        }
    }
}

#[test]
fn a_wrong_period_a_wrong_height_and_the_wrong_side_are_caught() {
    let grating = blazed(0.3, 100);
    let full = variant("mode = \"full\"");
    let found = by_twin(&height(&grating), &full, protocol(2.5));
    let right = closed(&grating, &full, protocol(2.5));
    assert!(apart(&found, &right) < CLOSED_NM);
    let longer = Grating::Blazed { period_um: 2.5001, height_um: 0.3, pixels: 100 };
    for wrong in [longer, blazed(0.27, 100)] {
        let wrong = closed(&wrong, &full, protocol(2.5));
        assert!(apart(&found, &wrong) > CLOSED_NM, "{wrong:?}");
    }
    // light from the other side meets the other flank: the same period, another efficiency
    let other = Protocol { phi_i_deg: 180.0, ..protocol(2.5) };
    let left = by_twin(&height(&grating), &full, other);
    assert!(apart(&left, &closed(&grating, &full, other)) < CLOSED_NM);
    assert!(apart(&left, &right) > CLOSED_NM, "{} {}", left.period_nm, left.sd_nm);
    assert!((left.period_nm - 2500.0).abs() < GRATING_NM);
}

/// Light that turns with the surface sees the same; a plane of incidence along the grooves sees no period.
#[test]
fn the_plane_of_incidence_turns_with_the_light() {
    let (height, full) = (height(&blazed(0.3, 100)), variant("mode = \"full\""));
    let straight = by_twin(&height, &full, protocol(2.5));
    let oblique = turned(&height, 30.0, &full, Protocol { phi_i_deg: 30.0, ..protocol(2.5) });
    assert!(apart(&straight, &oblique) < 1e-6);
    let expected = |along_deg| period::expected_um(&height, [true; 2], along_deg, "surface a");
    assert!((expected(0.0).unwrap() - 2.5).abs() < 1e-9);
    assert!((expected(-180.0).unwrap() - 2.5).abs() < 1e-9);
    let error = expected(90.0).unwrap_err().to_string();
    assert!(error.contains("surface a") && error.contains("--period-nm"), "{error}");
}

#[test]
fn evanescent_orders_are_left_out_and_counted() {
    let grating = Grating::Lamellar { period_um: 0.3, height_um: 0.1, pixels: 20, duty: 0.5 };
    let found = exactly(&height(&grating), protocol(0.3));
    // sin 75° - λ/d reaches -1 at 589.8 nm
    assert_eq!((found.points, found.evanescent, found.flat), (42, 39, 0));
    assert!((found.period_nm - 300.0).abs() < GRATING_NM);
    let flat = Grating::Flat { period_um: 2.5, pixels: 100 };
    let none = exactly(&height(&flat), protocol(2.5));
    assert_eq!((none.points, none.flat), (0, 81));
    assert_eq!(period::spread([&none]), None);
}

#[test]
fn a_mode_without_wavelengths_and_no_number_are_refused() {
    let height = height(&blazed(0.3, 100));
    let gems = variant("mode = \"gems\"");
    assert_eq!(gems.mode, Mode::Gems);
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &gems };
    let twin = TwinRunner::new(placement, true).unwrap();
    let (protocol, runner) = (protocol(2.5), &twin as &dyn Runner);
    let refused = period::measure(&protocol, 65.0, period::runner(runner, protocol));
    assert!(refused.unwrap_err().to_string().contains("no wavelength axis"));
    for wrong in [vec![], vec![f64::NAN; 100_000]] {
        let answer = |_: f64, angles: &[f64]| Ok(wrong[..angles.len().min(wrong.len())].to_vec());
        let error = period::measure(&protocol, 65.0, answer).unwrap_err().to_string();
        assert!(error.contains("380 nm"), "{error}");
    }
}

#[test]
fn the_picture_names_its_axes_and_the_table_reads_back() {
    let grating = blazed(0.3, 100);
    let protocol = Protocol { whole: true, ..protocol(2.5) };
    let profile = ClosedForm::new(&grating).unwrap();
    let matter = Matter::default();
    let lobe = |nm| Lobe::Window { sigma_um: window_sigma_um(&Optics::standard(), nm) };
    let respond = period::profile(&profile, protocol, (0.0, &matter), lobe);
    let found = period::measure(&protocol, 65.0, respond).unwrap();
    let picture = HeatmapText { title: "blazed, full & half", yardstick: Some(&found) };
    let svg = period::heatmap(&found, &protocol, picture).unwrap();
    for part in [
        "viewing angle θr, degrees",
        "wavelength, nm",
        "sin θi|, nm",
        "|P|², dB",
        "closed form",
        "blazed, full &amp; half",
        "prefers-color-scheme: dark",
    ] {
        assert!(svg.contains(part), "{part} is not in the picture");
    }
    // a circle for each peak on the map and beside it, and one in the legend
    assert_eq!(svg.matches("<circle").count(), 2 * 81 + 1);
    let plain = HeatmapText { title: "blazed", yardstick: None };
    assert!(!period::heatmap(&found, &protocol, plain).unwrap().contains("closed form"));

    let table = period::csv(&found);
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("wavelength_nm,theta_r_deg,response"));
    let read = lines.map(|line| {
        let numbers: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        (numbers[0], numbers[1], numbers[2])
    });
    let rows = found.rows.iter();
    let samples = rows.flat_map(|row| row.samples.iter().map(|s| (row.lambda_nm, s.0, s.1)));
    assert!(read.eq(samples));
    let ends = [&found.rows[0].samples[0], found.rows[0].samples.last().unwrap()];
    assert!(ends[0].0 < -89.0 && ends[1].0 > 89.0, "{ends:?}");
}

/// Windows of a measured skin differ by far more than the modes on any of them.
#[test]
fn windows_of_a_scan_agree_between_modes_and_differ_from_each_other() {
    let Some(path) = data::find("elaphe_65um.png") else { return };
    let text = format!(
        r#"schema = 1
[[surface]]
name = "elaphe"
file = {:?}
size_um = 65.0
height_um = 0.375
"#,
        path.canonicalize().unwrap()
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap();
    let scan = load(&plan.surfaces[0]).unwrap().field;
    let joins = facts(&scan, "elaphe").unwrap().joins;
    let expected_um = period::expected_um(&scan, joins, 0.0, "elaphe").unwrap();
    assert!((1.0..1.2).contains(&expected_um), "{expected_um}");
    let sparse = Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm: 40.0 };
    let protocol = Protocol { wavelengths: sparse, ..protocol(expected_um) };
    let full = variant("mode = \"full\"\nwindow_radius = 2");
    let mut windows = Vec::new();
    for crop in period::layout(&scan, 9, 12.0, "elaphe").unwrap() {
        let height = crop.of(&scan).unwrap();
        let exact = exactly(&height, protocol);
        assert!(apart(&by_twin(&height, &full, protocol), &exact) < CLOSED_NM, "{crop:?}");
        windows.push(exact);
    }
    let all = period::spread(&windows).unwrap();
    println!("{all:?}");
    assert_eq!(all.windows, 9);
    assert!((1000.0..1200.0).contains(&all.period_nm), "{all:?}");
    assert!((20.0..200.0).contains(&all.spread_nm) && all.sd_nm < all.spread_nm, "{all:?}");
}
