//! Facts of surfaces whose answers are known.

use crate::support::data;

use std::f64::consts::{PI, TAU};
use std::path::Path;

use crate::support::heights::{floats, folder, integers, png, put, surface};
use diffraction_shaders::input;
use diffraction_shaders::optics::Matter;
use diffraction_shaders::plan::{FileSource, Grating, Plan, SurfaceSpec};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::facts::{Facts, Periods, facts, periods};
use diffraction_shaders::surface::synthetic::synthesise;
use diffraction_shaders::survey::{Survey, height_picture, spectrum_picture, survey};
use image::{ExtendedColorType, RgbImage};

fn grating(grating: &Grating) -> HeightField {
    synthesise(grating, "grating").unwrap().field
}

fn blazed() -> HeightField {
    grating(&Grating::Blazed { period_um: 2.5, height_um: 0.3, pixels: 100 })
}

fn sinusoidal(period_um: f64, height_um: f64) -> Grating {
    Grating::Sinusoidal { period_um, height_um, pixels: 50 }
}

/// Heights over positions in µm, y upwards, the origin at the bottom left.
fn field(columns: usize, rows: usize, pitch_um: f64, h: impl Fn(f64, f64) -> f64) -> HeightField {
    let at =
        |i: usize| h((i % columns) as f64 * pitch_um, (rows - 1 - i / columns) as f64 * pitch_um);
    HeightField::new(columns, rows, pitch_um, pitch_um, (0..columns * rows).map(at).collect())
        .unwrap()
}

fn measured(field: &HeightField) -> Facts {
    facts(field, "probe").unwrap()
}

#[track_caller]
fn assert_near(got: f64, want: f64, tolerance: f64) {
    assert!((got - want).abs() <= tolerance, "{got}, not {want}");
}

/// A sawtooth of height H has the mean square H²/12, of which order m has H²/(2π²m²).
#[test]
fn a_blazed_grating_repeats_after_its_period() {
    let Periods { peaks, along_x, along_y, .. } = periods(&blazed(), [true; 2]);
    assert_eq!((peaks[0].period_um, peaks[0].direction_deg), (2.5, 0.0));
    assert_near(peaks[0].share, 6.0 / (PI * PI), 1e-3);
    assert_near(peaks[1].share, 6.0 / (4.0 * PI * PI), 1e-3);
    assert_eq!((along_x.mean_um, along_x.peaks[0].period_um), (Some(2.5), 2.5));
    assert_near(along_x.peaks[0].share, 6.0 / (PI * PI), 1e-3);
    assert!(along_y.peaks.is_empty() && along_y.mean_um.is_none());
    // read from a file it seems tilted and open, but without the tilt nothing would be left
    let facts = measured(&blazed());
    assert_eq!(facts.joins, [false, true]);
    let from_file = periods(&blazed(), facts.joins);
    assert_eq!((from_file.tiled, from_file.peaks[0].period_um), ([true; 2], 2.5));
}

#[test]
fn crossed_gratings_have_two_directions_and_shares_like_their_squares() {
    let (x, y) = (Box::new(sinusoidal(2.5, 0.1)), Box::new(sinusoidal(1.8, 0.2)));
    let found = periods(&grating(&Grating::Crossed { x, y }), [true; 2]);
    assert_eq!(found.peaks.len(), 2);
    for (peak, period_um, direction_deg, share) in
        [(found.peaks[0], 1.8, 90.0, 0.8), (found.peaks[1], 2.5, 0.0, 0.2)]
    {
        assert_near(peak.period_um, period_um, 1e-12);
        assert_near(peak.direction_deg, direction_deg, 1e-9);
        assert_near(peak.share, share, 1e-9);
    }
    assert_eq!(found.along_y.peaks[0].direction_deg, 90.0);
}

#[test]
fn a_direction_is_counted_from_x_towards_y_up_the_picture() {
    let oblique = field(64, 64, 0.05, |x, y| 0.1 * (TAU * (3.0 * x + 4.0 * y) / 3.2).cos());
    let found = periods(&oblique, measured(&oblique).joins);
    assert_eq!(found.tiled, [true; 2]);
    assert_near(found.peaks[0].direction_deg, 4f64.atan2(3.0).to_degrees(), 1e-9);
    assert_near(found.peaks[0].period_um, 3.2 / 5.0, 1e-12);
    assert_near(found.peaks[0].share, 1.0, 1e-12);
}

/// A scan: no whole number of periods, tilted, with a wave longer than itself.
#[test]
fn periods_between_bins_are_found_under_tilt_and_waviness() {
    let (fx, fy) = (1.0 / 1.147, 0.21);
    let scan = field(300, 200, 0.05, |x, y| {
        let wave = 0.15 * (TAU * x / 23.0).sin() + 0.02 * x - 0.03 * y;
        0.03 * (TAU * (fx * x + fy * y)).sin() + wave
    });
    let facts = measured(&scan);
    assert_eq!(facts.joins, [false; 2]);
    let found = periods(&scan, facts.joins);
    assert_eq!(found.tiled, [false; 2]);
    let best = found.peaks[0];
    assert_near(best.period_um, 1.0 / fx.hypot(fy), 2e-3);
    assert_near(best.direction_deg, fy.atan2(fx).to_degrees(), 0.3);
    assert_near(found.along_x.peaks[0].period_um, 1.147, 2e-3);
}

#[test]
fn relief_and_tilt_are_those_of_the_formula() {
    let facts = measured(&blazed());
    assert_near(facts.peak_to_valley_um, 0.297, 1e-12);
    assert_near(facts.rms_um, 0.3 / 12f64.sqrt(), 1e-4);
    assert_near(facts.levelled_peak_to_valley_um, 0.0, 1e-12);
    assert_near(facts.shortest_nm, 100.0, 1e-9);

    // rises by 0.02 to the right and by 0.01 up the picture; one speck
    let tilted = field(100, 80, 0.05, |x, y| {
        let speck = if (x - 2.0).abs() < 0.01 && (y - 1.0).abs() < 0.01 { 0.5 } else { 0.0 };
        0.02 * x + 0.01 * y + 0.05 * (TAU * x / 0.5).sin() * (TAU * y / 0.5).cos() + speck
    });
    let facts = measured(&tilted);
    assert_near(facts.tilt.direction_deg, 0.01f64.atan2(0.02).to_degrees(), 1.0);
    assert_near(facts.tilt.angle_deg, 0.02f64.hypot(0.01).atan().to_degrees(), 0.02);
    assert_near(facts.tilt.rise_um[0], 0.1, 2e-3);
    assert_near(facts.tilt.rise_um[1], 0.04, 2e-3);
    assert!(facts.peak_to_valley_um > 0.59 && facts.levelled_peak_to_valley_um > 0.5);
    assert_near(facts.trimmed_peak_to_valley_um, 0.1, 5e-3);

    let flat = measured(&field(8, 8, 0.05, |_, _| 0.2));
    assert_eq!((flat.peak_to_valley_um, flat.joins), (0.0, [true; 2]));
    let flat = periods(&field(8, 8, 0.05, |_, _| 0.2), [true; 2]);
    assert!(flat.peaks.is_empty() && flat.along_x.peaks.is_empty());
}

fn plan(rest: &str) -> Plan {
    let text = format!(
        r#"schema = 1
[[surface]]
name = "probe"
grating = {{ kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 100 }}
{rest}"#
    );
    let dir = folder();
    input::read_plan(&put(&dir, "plan.toml", text.as_bytes())).unwrap()
}

fn inspected(plan: &Plan, spec: &SurfaceSpec) -> Survey {
    survey(plan, spec).unwrap().0
}

#[test]
fn terms_window_and_cost_are_those_of_the_plan() {
    let plan = plan(
        r#"[variants]
mode = ["full"]
terms = ["auto"]
"#,
    );
    let found = inspected(&plan, &plan.surfaces[0]);
    assert_eq!((found.wanted_nm, found.wanted_pitch_um), (380.0, 0.095));
    assert_eq!(found.terms[0].terms, [14, 16, 18]);
    assert_eq!(found.terms[1].terms, [27, 29, 31]);
    assert_eq!(found.terms[0].levelled, [1, 1, 1]);
    // `terms = "auto"` keeps 1e-3
    assert_eq!(found.variants[0].terms, Some(18));
    assert_eq!(found.window.overlap, [false; 2]);
    assert_near(found.window.sigma_bins[0], 2.5 / (TAU * 16.25), 1e-12);
    assert_eq!((found.step_um, found.void_pixels), (None, 0));
}

#[test]
fn files_tell_steps_voids_and_a_seam() {
    let mut pixels: Vec<u8> = (0..50 * 40).flat_map(|i| [(i * 5 % 250) as u8, 255]).collect();
    for i in 0..20 {
        pixels[2 * (3 * 50 + i) + 1] = 0;
    }
    let dir = folder();
    let path = put(&dir, "a.png", &png(50, 40, ExtendedColorType::La8, &pixels));
    let plan = plan("[optics]\ncoherence_um = 4.0\n");
    let found = inspected(&plan, &surface(FileSource { pixel_um: Some(0.05), ..integers(&path) }));
    // every fifth of 255 levels of 2 nm; the last seam of the ramp is open
    assert_near(found.step_um.unwrap(), 0.01, 1e-12);
    assert_eq!(found.void_pixels, 20);
    assert_near(found.void_share, 0.01, 1e-12);
    assert_eq!(found.facts.joins, [false, true]);
    assert!(found.window.overlap[0] && found.window.meaning[1].contains("seam"));
    assert_eq!(found.notes.len(), 2, "{:?}", found.notes);
}

/// Finger spacing of the measured skin.
#[test]
fn fingers_of_the_scan_are_found() {
    let Some(path) = data::find("elaphe_65um.png") else { return };
    let source = FileSource {
        size_um: Some(65.0),
        pixel_um: None,
        height_um: Some(0.375),
        ..floats(Path::new(&path))
    };
    let plan = plan("");
    let found = inspected(&plan, &surface(source));
    let best = found.periods.peaks[0];
    assert!((1.12..1.18).contains(&best.period_um), "{best:?}");
    assert!(best.direction_deg < 2.0 || best.direction_deg > 178.0, "{best:?}");
    let along_x = &found.periods.along_x;
    assert!((1.0..1.18).contains(&along_x.mean_um.unwrap()) && along_x.share > 0.4, "{along_x:?}");
    assert_eq!(found.periods.tiled, [false; 2]);
    assert_near(found.facts.peak_to_valley_um, 0.375, 1e-9);
    assert_eq!(found.terms[0].terms[1], 19);
    assert_eq!(found.window.overlap, [true; 2]);
}

fn decoded(bytes: &[u8]) -> RgbImage {
    image::load_from_memory(bytes).unwrap().to_rgb8()
}

/// The place of the first pixel of a colour, in reading order, and how many there are.
fn colour(picture: &RgbImage, wanted: [u8; 3]) -> (Option<(u32, u32)>, usize) {
    let mut places =
        picture.enumerate_pixels().filter(|(_, _, p)| p.0 == wanted).map(|(x, y, _)| (x, y));
    (places.next(), 1 + places.count())
}

const LOWEST: [u8; 3] = [68, 1, 84];
const HIGHEST: [u8; 3] = [253, 231, 37];

#[test]
fn the_height_picture_is_upright() {
    // high at the top right, low at the bottom left
    let corner = field(40, 40, 0.05, |x, y| match (x > 1.5, y > 1.5) {
        (true, true) => 0.3,
        (false, false) if x < 0.4 && y < 0.4 => 0.0,
        _ => 0.15,
    });
    let picture = decoded(&height_picture(&corner, "probe").unwrap());
    // the first of the area's pixels in reading order is that of the top corner
    let (Some((x, y)), many) = colour(&picture, HIGHEST) else { panic!("nothing is high") };
    assert!(x > picture.width() / 2 && y < picture.height() / 4 && many > 1000, "{x}, {y}, {many}");
    let (Some((x, y)), many) = colour(&picture, LOWEST) else { panic!("nothing is low") };
    assert!(x < picture.width() / 2 && y > picture.height() / 2 && many > 1000, "{x}, {y}, {many}");
}

#[test]
fn the_spectrum_of_a_mirror_is_one_order_in_the_middle() {
    let flat = field(20, 20, 0.05, |_, _| 0.1);
    let picture = decoded(&spectrum_picture(&flat, &Matter::default(), "probe").unwrap());
    let is_bright = |[r, _, b]: [u8; 3]| r > 235 && b < 60;
    // the bar of colours lies to the right
    let lit = |picture: &RgbImage| -> Vec<(u32, u32)> {
        let pixels = picture.enumerate_pixels().filter(|(x, _, p)| *x < 800 && is_bright(p.0));
        pixels.map(|(x, y, _)| (x, y)).collect()
    };
    let mirror = lit(&picture);
    let mean = |values: &mut dyn Iterator<Item = u32>| {
        values.map(f64::from).sum::<f64>() / mirror.len() as f64
    };
    assert!((60..100).contains(&mirror.len()), "{} pixels", mirror.len());
    assert_near(mean(&mut mirror.iter().map(|p| p.0)), 80.0 + 360.0, 2.0);
    assert_near(mean(&mut mirror.iter().map(|p| p.1)), 56.0 + 360.0, 2.0);
    // a blazed grating sends its light to one side
    let blazed = lit(&decoded(&spectrum_picture(&blazed(), &Matter::default(), "probe").unwrap()));
    assert!(!blazed.is_empty() && blazed.iter().all(|(x, _)| (460..490).contains(x)), "{blazed:?}");
}

#[test]
fn pictures_of_any_shape_can_be_drawn() {
    let shapes = [
        field(2, 2, 0.05, |x, y| x + y),
        field(3, 200, 0.05, |x, y| x * y),
        field(400, 2, 0.05, |x, y| x * (1.0 + y)),
        field(4, 50, 0.05, |_, y| y),
        field(4, 4, 0.05, |_, _| 0.0),
        field(1500, 30, 0.05, |x, y| (x * y).sin()),
    ];
    for shape in &shapes {
        for picture in
            [height_picture(shape, "probe"), spectrum_picture(shape, &Matter::default(), "probe")]
        {
            let picture = decoded(&picture.unwrap());
            assert!(picture.width() > 160 && picture.height() > 160);
        }
    }
}
