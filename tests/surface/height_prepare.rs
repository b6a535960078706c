//! Voids, levelling, clipping, extrusion, pitch.

use crate::support::heights::*;
use diffraction_shaders::input;
use diffraction_shaders::plan::{Level, SurfaceSpec};
use diffraction_shaders::surface::{EXTRUDED, HeightField, Surface, level};

fn field(columns: usize, rows: usize, height: impl Fn(usize, usize) -> f64) -> HeightField {
    let heights = (0..columns * rows).map(|i| height(i % columns, i / columns)).collect();
    HeightField::new(columns, rows, 0.05, 0.05, heights).unwrap()
}

fn as_text(columns: usize, rows: usize, height: impl Fn(usize, usize) -> f64) -> String {
    let line =
        |r: usize| (0..columns).map(|c| height(c, r).to_string()).collect::<Vec<_>>().join(" ");
    (0..rows).map(line).collect::<Vec<_>>().join("\n")
}

fn load(
    text: &str,
    change: impl Fn(&mut SurfaceSpec),
) -> diffraction_shaders::error::Result<Surface> {
    let dir = folder();
    let mut spec = surface(floats(&put(&dir, "a.txt", text.as_bytes())));
    change(&mut spec);
    input::load_surface(&spec)
}

#[test]
fn voids_continue_a_slope_and_are_counted() {
    let slope = |c: usize, r: usize| 0.01 * c as f64 + 0.02 * r as f64;
    let hole = |c: usize, r: usize| (4..9).contains(&c) && (3..8).contains(&r);
    let text = as_text(20, 16, |c, r| if hole(c, r) { f64::NAN } else { slope(c, r) });
    let Surface { field, notes } = load(&text, |_| {}).unwrap();
    for (i, h) in field.heights_um().iter().enumerate() {
        let wanted = slope(i % 20, i / 20);
        assert!((h - wanted).abs() < 1e-4, "pixel {i}: {h}, not {wanted}");
    }
    assert_eq!(notes.len(), 1);
    assert!(notes[0].contains("25 of 320"), "{notes:?}");
}

#[test]
fn voids_at_edges_stay_in_range_and_do_not_wrap_around() {
    // left half 0, right half 1, the left column void: a periodic fill would see the 1
    let text = as_text(10, 4, |c, _| if c == 0 { f64::NAN } else { f64::from(u8::from(c > 5)) });
    let Surface { field, .. } = load(&text, |_| {}).unwrap();
    assert!((0..4).all(|r| field.heights_um()[r * 10].abs() < 1e-6));
}

#[test]
fn too_many_voids_are_refused() {
    let share =
        |limit: usize| as_text(10, 10, |c, r| if r * 10 + c < limit { f64::NAN } else { 0.1 });
    assert!(load(&share(20), |_| {}).is_ok());
    assert_says(load(&share(21), |_| {}), &["probe", "a.txt", "21 of 100", "20 %", "crop"]);
    assert_says(load(&share(100), |_| {}), &["every pixel is void"]);
}

#[test]
fn a_plane_is_removed_and_relief_is_kept() {
    let relief = |c: usize, r: usize| if (c + r).is_multiple_of(2) { 0.1 } else { -0.1 };
    let tilted = field(8, 6, |c, r| 3.0 + 0.4 * c as f64 - 0.7 * r as f64 + relief(c, r));
    let flat = level::level(tilted, Level::Plane, "probe").unwrap();
    for (i, h) in flat.heights_um().iter().enumerate() {
        // a chessboard of even size has a small plane of its own
        assert!((h - relief(i % 8, i / 8)).abs() < 0.03, "pixel {i}: {h}");
    }
    let exact =
        level::level(field(8, 6, |c, r| 1.0 + 0.4 * c as f64 - 0.7 * r as f64), Level::Plane, "p")
            .unwrap();
    assert!(exact.heights_um().iter().all(|h| h.abs() < 1e-12));
    let profile = level::level(field(5, 1, |c, _| c as f64), Level::Plane, "p").unwrap();
    assert!(profile.heights_um().iter().all(|h| h.abs() < 1e-12));
}

#[test]
fn row_offsets_are_removed_by_the_median() {
    // one outlier per row does not move a median
    let shifted = field(5, 3, |c, r| r as f64 + [0.0, 0.1, 0.2, 0.3, 50.0][c]);
    let levelled = level::level(shifted, Level::Rows, "probe").unwrap();
    for r in 0..3 {
        let row = &levelled.heights_um()[5 * r..5 * r + 5];
        assert!(
            (row[0] + 0.2).abs() < 1e-12 && row[2].abs() < 1e-12 && (row[4] - 49.8).abs() < 1e-12,
            "{row:?}"
        );
    }
    let even = level::level(field(4, 1, |c, _| c as f64), Level::Rows, "probe").unwrap();
    assert_eq!(even.heights_um(), [-1.5, -0.5, 0.5, 1.5]);
    assert_says(
        level::level(field(1, 4, |_, r| r as f64), Level::Rows, "probe"),
        &["probe", "single column", "plane"],
    );
    let same = level::level(field(4, 1, |c, _| c as f64), Level::None, "probe").unwrap();
    assert_eq!(same.heights_um(), [0.0, 1.0, 2.0, 3.0]);
}

#[test]
fn clipping_takes_a_share_at_each_end() {
    let ramp = field(100, 1, |c, _| ((c * 37) % 100) as f64);
    let (clipped, note) = level::clip(ramp.clone(), 5.0, "probe").unwrap();
    assert_eq!(clipped.range_um(), (5.0, 94.0));
    assert_eq!(
        clipped.heights_um().iter().zip(ramp.heights_um()).filter(|(a, b)| a != b).count(),
        10
    );
    assert!(note.unwrap().contains("10 of 100"));
    let (most, _) = level::clip(ramp.clone(), 49.99, "probe").unwrap();
    assert!(most.range_um().0 <= most.range_um().1);
    assert_eq!(level::clip(ramp.clone(), 0.0, "probe").unwrap(), (ramp.clone(), None));
    for bad in [-1.0, 50.0, 100.0, f64::NAN] {
        assert_says(level::clip(ramp.clone(), bad, "probe"), &["probe", "clip_percent", "50"]);
        assert_says(load("1 2\n3 4\n", |s| s.clip_percent = bad), &["clip_percent"]);
    }
}

#[test]
fn levelling_comes_before_clipping() {
    // after the tilt is gone only the speck is an outlier
    let text = as_text(20, 20, |c, r| 0.1 * c as f64 + if (c, r) == (3, 4) { 5.0 } else { 0.0 });
    let levelled = load(&text, |s| {
        s.level = Level::Plane;
        s.clip_percent = 0.5;
    })
    .unwrap();
    let (low, high) = levelled.field.range_um();
    assert!(high - low < 0.2, "{low} {high}");
    assert!(levelled.notes.iter().any(|n| n.contains("clipped")), "{:?}", levelled.notes);
}

#[test]
fn profiles_are_extruded() {
    let row = load("0 1 2 3 4\n", |_| {}).unwrap();
    assert_eq!((row.field.columns(), row.field.rows()), (5, EXTRUDED));
    assert_eq!((row.field.pitch_x_um(), row.field.pitch_y_um()), (0.1, 0.1));
    assert!(row.field.heights_um().chunks(5).all(|r| r == [0.0, 1.0, 2.0, 3.0, 4.0]));
    assert!(
        row.notes.iter().any(|n| n.contains("profile") && n.contains("5 × 4")),
        "{:?}",
        row.notes
    );
    let column = load("0\n1\n2\n", |_| {}).unwrap();
    assert_eq!((column.field.columns(), column.field.rows()), (EXTRUDED, 3));
    assert_eq!(column.field.heights_um()[EXTRUDED..2 * EXTRUDED], [1.0; EXTRUDED]);
    assert_says(load("7\n", |_| {}), &["probe", "single pixel", "two pixels"]);
    let full = field(2, 2, |c, _| c as f64);
    assert_eq!(full.extruded().unwrap(), full);
}

#[test]
fn the_pitch_must_resolve_the_shortest_wavelength() {
    let coarse = HeightField::new(100, 50, 0.09, 0.1, vec![0.0; 5000]).unwrap();
    assert!(coarse.check_pitch("probe", 400.0).is_ok());
    assert_says(
        coarse.check_pitch("probe", 380.0),
        &["probe", "along y", "100.0000 nm", "95.0000 nm", "53 pixels", "400 nm"],
    );
    assert_says(coarse.check_pitch("probe", 350.0), &["along x"]);
    // exactly a quarter is enough, whatever the last bit of a division says
    let exact = HeightField::new(10, 10, 0.95 / 10.0, 0.95 / 10.0, vec![0.0; 100]).unwrap();
    assert!(exact.check_pitch("probe", 380.0).is_ok());
    assert!(exact.check_pitch("probe", f64::NAN).is_err());
}
