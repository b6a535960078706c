//! Tables that are no matrices: points, profiles, matrices with coordinates.

use crate::support::heights::*;
use diffraction_shaders::error::Result;
use diffraction_shaders::input::read_heights as read;
use diffraction_shaders::plan::FileSource;
use diffraction_shaders::surface::read::Reading;

fn with(name: &str, bytes: impl AsRef<[u8]>, keys: FileSource) -> Result<Reading> {
    let dir = folder();
    let path = put(&dir, name, bytes.as_ref());
    read(&FileSource { path, ..keys }, "probe")
}

fn open(bytes: impl AsRef<[u8]>) -> Result<Reading> {
    with("a.txt", bytes, FileSource::default())
}

#[track_caller]
fn assert_pitch(reading: &Reading, x: f64, y: f64) {
    let found = (reading.pitch_x_um, reading.pitch_y_um);
    assert!((found.0 / x - 1.0).abs() < 1e-9 && (found.1 / y - 1.0).abs() < 1e-9, "{found:?}");
}

/// The points of the test surface, pixels of 0.5 × 0.25, y upwards.
fn points() -> Vec<[f64; 3]> {
    (0..COLUMNS * ROWS)
        .map(|i| {
            let (col, row) = (i % COLUMNS, i / COLUMNS);
            let y = 0.25 * (ROWS - 1 - row) as f64;
            [0.5 * col as f64 - 3.0, y, f64::from(grey(col, row)) / 100.0]
        })
        .collect()
}

fn listed(points: &[[f64; 3]], between: &str) -> String {
    points.iter().map(|p| p.map(|v| format!("{v:.3}")).join(between) + "\n").collect()
}

#[test]
fn points_in_any_order_and_spelling() {
    let by_row = points();
    let mut by_column = points();
    by_column.sort_by(|a, b| a[0].total_cmp(&b[0]).then(b[1].total_cmp(&a[1])));
    let backwards: Vec<_> = points().into_iter().rev().collect();
    // 7 and 15 have no common divisor: every point once
    let mixed: Vec<_> = (0..15).map(|i| points()[i * 7 % 15]).collect();
    for order in [by_row, by_column, backwards, mixed] {
        for between in [" ", "\t", ",", "; "] {
            let reading = open(listed(&order, between)).unwrap();
            assert_upright(&reading, 0.01);
            assert_pitch(&reading, 0.5, 0.25);
            let says = |n: &String| n.contains("no unit") && n.contains("µm");
            assert!(reading.notes.iter().any(says), "{:?}", reading.notes);
        }
    }
    // blank lines between scan lines, as some plotting programs want them
    let parted: String = points().chunks(5).map(|line| listed(line, " ") + "\n").collect();
    assert_upright(&open(parted).unwrap(), 0.01);
}

#[test]
fn points_take_the_units_of_their_columns() {
    let text = listed(&points(), " ");
    for (header, lateral, height) in [
        ("# x y z in um", 1.0, 1.0),
        ("X[nm]\tY[nm]\tZ[nm]", 1e-3, 1e-3),
        ("WSxM file copyright UAM\nWSxM ASCII XYZ file\nX[nm]\tY[nm]\tZ[pm]\n", 1e-3, 1e-6),
        ("x (µm), y (µm), height (nm)", 1.0, 1e-3),
        ("# Value units: nm", 1e-3, 1e-3),
    ] {
        let reading = open(format!("{header}\n{text}")).unwrap();
        let h = reading.heights_um[0];
        assert!((h / (0.07 * height) - 1.0).abs() < 1e-9, "{header}: {h}");
        assert_pitch(&reading, 0.5 * lateral, 0.25 * lateral);
    }
    // more columns than three
    let four: String = text.lines().map(|line| format!("{line} 9\n")).collect();
    let named = format!("# x y height_nm phase_deg\n{four}");
    assert_upright(&open(named).unwrap(), 1e-5);
}

#[test]
fn the_plan_has_to_agree_with_coordinates() {
    let square: Vec<[f64; 3]> =
        points().into_iter().map(|[x, y, z]| [x * 100.0, y * 200.0, z]).collect();
    let text = listed(&square, " ");
    // 50 of a unit that is not stated, 0.05 µm in the plan: nm
    let keys = |pixel| FileSource { pixel_um: Some(pixel), ..FileSource::default() };
    let reading = with("a.xyz", &text, keys(0.05)).unwrap();
    assert_upright(&reading, 0.01);
    assert_pitch(&reading, 0.05, 0.05);
    assert_says(
        with("a.xyz", &text, keys(0.06)),
        &["pixel_um = 0.06", "coordinates", "50 per pixel"],
    );
    let stated = format!("# x y z in nm\n{text}");
    assert_says(with("a.xyz", stated, keys(50.0)), &["pixel_um = 50", "0.05 × 0.05 µm", "trust"]);
}

#[test]
fn points_on_no_grid_are_refused() {
    let text = |points: &[[f64; 3]]| format!("x y z\n{}", listed(points, " "));
    let mut missing = points();
    missing.remove(4);
    assert_says(
        open(text(&missing)),
        &["14 points fill only 93.3 % of a grid of 5 × 3", "1 are missing"],
    );
    let mut twice = points();
    twice.push(twice[3]);
    assert_says(open(text(&twice)), &["two points lie at x = -1.5, y = 0.5"]);
    let uneven: Vec<_> = points().into_iter().map(|[x, y, z]| [x * x, y, z]).collect();
    assert_says(open(text(&uneven)), &["not evenly spaced", "interpolate"]);
    let scattered: Vec<_> = (0..60)
        .map(f64::from)
        .map(|i| [(i * 0.618).fract(), (i * 0.414).fract(), (i * 0.2).sin()])
        .collect();
    assert_says(open(text(&scattered)), &["no regular grid"]);
    // without names: too many rows for a matrix of three columns
    assert_says(open(listed(&scattered, " ")), &["60 rows of three numbers", "points"]);
    // a few rows of three heights remain a matrix
    let small = with(
        "a.txt",
        "1 5 2\n4 1 3\n2 2 9\n7 3 1\n",
        FileSource { pixel_um: Some(0.1), z_unit_um: Some(0.01), ..FileSource::default() },
    )
    .unwrap();
    assert_eq!((small.columns, small.rows), (3, 4));
}

#[test]
fn distances_and_heights_are_a_profile() {
    let line =
        |i: u32, rise: f64| format!("{:.2},{}\n", f64::from(i) * rise, f64::from(i * i % 7) / 10.0);
    let text: String = (0..20).map(|i| line(i, 0.05)).collect();
    let check = |text: &str, pitch: f64, unit: f64| {
        let reading = open(text).unwrap();
        assert_eq!((reading.columns, reading.rows), (20, 1), "{text}");
        assert!((reading.pitch_x_um / pitch - 1.0).abs() < 1e-9, "{}", reading.pitch_x_um);
        for (i, h) in reading.heights_um.iter().enumerate() {
            assert!((h - (i * i % 7) as f64 / 10.0 * unit).abs() < 1e-12, "{i}: {h}");
        }
    };
    check(&text, 0.05, 1.0);
    check(&format!("# distance_um,height_nm\n{text}"), 0.05, 1e-3);
    check(&format!("Distance [mm],Z [µm]\n{text}"), 50.0, 1.0);
    let backwards: String = (0..20).rev().map(|i| line(i, 0.05)).collect();
    check(&backwards, 0.05, 1.0);
    // the plan's pitch has to agree
    let keys = |pixel| FileSource { pixel_um: Some(pixel), ..FileSource::default() };
    assert!(with("a.csv", &text, keys(0.05)).is_ok());
    assert_says(with("a.csv", &text, keys(0.07)), &["pixel_um = 0.07", "distances"]);
    // uneven distances are no profile, two short rows no distances
    let uneven: String = (0..20).map(|i| line(i * i, 0.05)).collect();
    assert_says(open(uneven), &["not evenly spaced", "resample"]);
    let two = with("a.txt", "0 1\n1 2\n", keys(0.1)).unwrap();
    assert_eq!((two.columns, two.rows), (2, 2));
}

#[test]
fn coordinates_around_a_matrix_are_used_as_its_scale() {
    let body = |corner: &str, between: &str, downwards: bool| {
        let xs = (0..COLUMNS).map(|c| format!("{:.2}", 0.5 * c as f64)).collect::<Vec<_>>();
        let mut text = format!("{corner}{between}{}\n", xs.join(between));
        for (row, heights) in rows(between).into_iter().enumerate() {
            let y = if downwards { ROWS - 1 - row } else { row } as f64;
            text += &format!("{:.2}{between}{heights}\n", 0.25 * y);
        }
        text
    };
    for (corner, between) in
        [("nan", " "), ("", "\t"), ("", ";"), ("", ","), ("y/x", ";"), ("NaN", ",")]
    {
        let reading =
            open(body(corner, between, true)).unwrap_or_else(|e| panic!("{corner}{between}: {e}"));
        assert_upright(&reading, 0.01);
        assert_pitch(&reading, 0.5, 0.25);
        // where y grows downwards in the file, the last row is the top one
        let turned = open(body(corner, between, false)).unwrap();
        assert_eq!(turned.heights_um[..5], reading.heights_um[10..]);
    }
}

#[test]
fn rows_that_may_be_coordinates_or_heights_are_refused() {
    let keys = || FileSource { pixel_um: Some(0.1), ..FileSource::default() };
    let refused = |text: &str, part: &str| {
        assert_says(with("a.txt", text, keys()), &[part, "coordinates or heights", "nan"]);
    };
    refused("0 1 2 3\n5 2 9 1\n4 4 2 8\n7 1 1 3\n", "the first row is");
    refused("0 5 2 9\n1 4 4 2\n2 7 1 1\n3 0 2 6\n", "the first column is");
    // slopes and steps are heights
    for heights in [
        "0 1 2 3\n1 2 3 4\n2 3 4 5\n3 4 5 6\n",
        "0 1 2 3\n0 1 2 3\n0 1 2 3\n",
        "1 1 1 1\n5 2 9 1\n4 4 2 8\n",
    ] {
        let reading = with("a.txt", heights, keys()).unwrap();
        assert_eq!(reading.columns, 4);
    }
}
