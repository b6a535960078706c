//! Keys of a surface with a file: `size_y_um`, `flip`, `resample_um`, extensions, and what of them a hash knows.

use std::f64::consts::TAU;

use crate::support::heights::*;
use diffraction_shaders::error::shell_path;
use diffraction_shaders::input::{SurfaceInput, load_surface, read_heights as read};
use diffraction_shaders::plan::{FileSource, Flip, Level, SurfaceSpec, Trust, VoidValue};
use diffraction_shaders::surface::{HeightField, write_gsf};

#[test]
fn both_sizes_make_oblong_pixels() {
    let dir = folder();
    let path = put(&dir, "a.png", &grey_png());
    let with = |keys: FileSource| {
        read(&FileSource { path: path.clone(), height_um: Some(0.51), ..keys }, "probe")
    };
    let none = FileSource::default;
    for (keys, x, y) in [
        (FileSource { size_um: Some(2.0), size_y_um: Some(0.3), ..none() }, 0.4, 0.1),
        (FileSource { size_um: Some(2.0), ..none() }, 0.4, 0.4),
        (FileSource { size_y_um: Some(0.3), ..none() }, 0.1, 0.1),
    ] {
        let reading = with(keys).unwrap();
        assert!((reading.pitch_x_um - x).abs() < 1e-12 && (reading.pitch_y_um - y).abs() < 1e-12);
    }
    let both = FileSource { size_y_um: Some(1.0), pixel_um: Some(0.1), ..none() };
    assert_says(with(both), &["size_y_um = 1", "pixel_um = 0.1", "remove one"]);
    let profile = put(&dir, "b.txt", b"1\n2\n4\n");
    let source = FileSource { size_um: Some(1.0), size_y_um: Some(1.0), ..bare(&profile) };
    assert_says(read(&source, "probe"), &["size_y_um = 1", "profile"]);
}

#[test]
fn rows_or_columns_are_turned_round() {
    let dir = folder();
    let path = put(&dir, "a.png", &grey_png());
    let turned = |flip| read(&FileSource { flip, ..integers(&path) }, "probe").unwrap();
    let level = |h: f64| (h * 255.0 / 0.51).round() as u8;
    let corner = |flip| level(turned(flip).heights_um[0]);
    assert_eq!(corner(Flip::None), grey(0, 0));
    assert_eq!(corner(Flip::Rows), grey(0, ROWS - 1));
    assert_eq!(corner(Flip::Columns), grey(COLUMNS - 1, 0));
}

/// A sine of `waves` periods over `size` µm.
fn sine(waves: f64, columns: usize, size: f64) -> HeightField {
    let height =
        |i: usize| 0.05 * (TAU * waves * (i % columns) as f64 / columns as f64 + 0.3).sin();
    let pitch = size / columns as f64;
    HeightField::new(columns, 8, pitch, pitch, (0..columns * 8).map(height).collect()).unwrap()
}

fn resampled(field: &HeightField, pitch_um: f64) -> (HeightField, String) {
    let dir = folder();
    let path = put(&dir, "a.gsf", &write_gsf(field));
    let spec = surface(FileSource { resample_um: Some(pitch_um), ..bare(&path) });
    let loaded = load_surface(&spec).unwrap();
    (loaded.field, loaded.notes.join("\n"))
}

#[track_caller]
fn assert_sine(found: &HeightField, waves: f64, tolerance: f64) {
    let columns = found.columns();
    for (i, h) in found.heights_um().iter().enumerate() {
        let wanted = 0.05 * (TAU * waves * (i % columns) as f64 / columns as f64 + 0.3).sin();
        assert!((h - wanted).abs() < tolerance, "{i}: {h}, not {wanted}");
    }
}

#[test]
fn resampling_keeps_what_both_pitches_hold() {
    for pitch in [0.045, 0.09, 0.1, 0.17] {
        let (found, note) = resampled(&sine(3.0, 32, 3.2), pitch);
        assert_eq!(found.columns(), (3.2f64 / pitch - 1e-9).ceil() as usize);
        assert!((found.size_x_um() - 3.2).abs() < 1e-12 && (found.size_y_um() - 0.8).abs() < 1e-12);
        assert_sine(&found, 3.0, 1e-7);
        assert_eq!(note.contains("nothing finer than 200 nm"), pitch < 0.1, "{note}");
        assert_eq!(note.contains("0.00 % of the variance"), pitch > 0.1, "{note}");
    }
}

#[test]
fn resampling_says_what_it_loses() {
    // three periods stay, twelve lie beyond the new Nyquist frequency
    let slow = sine(3.0, 32, 3.2);
    let fast = |i: usize| {
        0.025 * (TAU * (12.0 * (i % 32) as f64 / 32.0 + 3.0 * (i / 32) as f64 / 8.0)).sin()
    };
    let sum = slow.heights_um().iter().enumerate().map(|(i, h)| h + fast(i)).collect();
    let field = HeightField::new(32, 8, 0.1, 0.1, sum).unwrap();
    let (found, note) = resampled(&field, 0.2);
    assert_eq!((found.columns(), found.rows()), (16, 4));
    assert_sine(&found, 3.0, 1e-7);
    // (1/2)² against 1 + (1/2)²
    assert!(note.contains("20.00 % of the variance"), "{note}");
}

/// A patch that does not join itself keeps its edges: no ripples from the seam.
#[test]
fn resampling_of_a_slope_does_not_ripple() {
    let slope: Vec<f64> = (0..32 * 8).map(|i| 0.01 * f64::from(i % 32)).collect();
    let field = HeightField::new(32, 8, 0.1, 0.1, slope).unwrap();
    let (found, _) = resampled(&field, 0.05);
    for (i, h) in found.heights_um()[..64].iter().enumerate() {
        let wanted = (0.005 * i as f64).min(0.31);
        assert!((h - wanted).abs() < 0.002, "{i}: {h}, not {wanted}");
    }
}

#[test]
fn resampling_of_a_profile_keeps_it_a_profile() {
    let dir = folder();
    let path = put(&dir, "a.txt", "0 0.1 0.2 0.1 ".repeat(4).as_bytes());
    let source = FileSource { pixel_um: Some(0.1), resample_um: Some(0.05), ..bare(&path) };
    let found = load_surface(&surface(source)).unwrap();
    assert_eq!((found.field.columns(), found.field.rows()), (32, 4));
    let huge = FileSource { pixel_um: Some(0.1), resample_um: Some(1e-5), ..bare(&path) };
    assert_says(load_surface(&surface(huge)), &["160000 × 1 pixels", "limit"]);
}

#[test]
fn resampling_comes_after_levelling_and_voids() {
    let dir = folder();
    let path = put(&dir, "a.txt", b"0 1 2 3\n0 1 nan 3\n0 1 2 3\n0 1 2 3\n");
    let source = FileSource { z_unit_um: Some(0.1), resample_um: Some(0.05), ..floats(&path) };
    let spec = SurfaceSpec { level: Level::Plane, ..surface(source) };
    let found = load_surface(&spec).unwrap();
    let (low, high) = found.field.range_um();
    assert!(found.field.columns() == 8 && high - low < 0.01, "{low} {high}");
}

#[test]
fn advice_about_a_coarse_pitch_names_both_axes() {
    let field = HeightField::new(4, 4, 0.2, 0.15, vec![0.0; 16]).unwrap();
    let coarse = field.check_pitch("surface s", 380.0);
    assert_says(
        coarse,
        &["200.0000 nm along x and 150.0000 nm along y", "resample_um = 0.095", "at least 800 nm"],
    );
    let one = HeightField::new(4, 4, 0.05, 0.15, vec![0.0; 16]).unwrap();
    let text = one.check_pitch("surface s", 380.0).unwrap_err().to_string();
    assert!(text.contains("along y") && !text.contains("along x"), "{text}");
    assert!(one.check_pitch("surface s", 600.0).is_ok());
}

#[test]
fn every_key_of_a_file_is_part_of_its_hash() {
    let dir = folder();
    let path = put(&dir, "a.txt", b"0.1 0.2\n0.3 0.5\n");
    let identity =
        |source: FileSource| SurfaceInput::read(&surface(source)).unwrap().identity().to_owned();
    let base = || FileSource { size_um: Some(1.0), ..bare(&path) };
    let other = put(&dir, "b.txt", b"0.1 0.2\n0.3 0.5\n");
    assert_eq!(identity(base()), identity(FileSource { path: other, ..base() }));
    let variants = [
        base(),
        FileSource { size_um: Some(2.0), ..base() },
        FileSource { size_y_um: Some(1.0), ..base() },
        FileSource { size_um: None, pixel_um: Some(1.0), ..base() },
        FileSource { z_unit_um: Some(1.0), ..base() },
        FileSource { height_um: Some(1.0), ..base() },
        FileSource { channel: Some("1".into()), ..base() },
        FileSource { void_value: Some(VoidValue::Number(1.0)), ..base() },
        FileSource { void_value: Some(VoidValue::None), ..base() },
        FileSource { flip: Flip::Rows, ..base() },
        FileSource { flip: Flip::Columns, ..base() },
        FileSource { trust: Trust::Plan, ..base() },
        FileSource { resample_um: Some(0.1), ..base() },
    ];
    let count = variants.len();
    let hashes: std::collections::BTreeSet<String> = variants.map(identity).into();
    assert_eq!(hashes.len(), count);
}

#[test]
fn files_of_instruments_are_sent_to_import() {
    let dir = folder();
    for extension in [
        "spm", "ibw", "nid", "gwy", "x3p", "sur", "opd", "SDF", "mi", "al3d", "plu", "top", "di",
        "nms", "opdx", "mnt", "mat", "h5", "dm3", "001",
    ] {
        let path = put(&dir, &format!("my scan.{extension}"), b"\0\x01\x02\x03");
        let wanted = format!("cargo xtask import {}", shell_path(&path));
        assert_says(read(&floats(&path), "probe"), &["format of instruments", &wanted]);
    }
    // binary content under a name of text, and formats of text that are not read
    for (name, bytes) in [
        ("a.dat", b"\x88\x1b\x03\x6f\0\0\0\0".as_slice()),
        ("b.txt", b"aISO-1.0\nManufacID = x\n"),
        ("c.asc", b"Wyko ASCII Data File Format 0\t1\t1\n"),
    ] {
        assert_says(read(&floats(&put(&dir, name, bytes)), "probe"), &["cargo xtask import"]);
    }
    assert_says(
        read(&floats(&put(&dir, "a.jpg", b"x")), "probe"),
        &["`jpg`", "gsf", "tsv", "import"],
    );
    for extension in ["asc", "dat", "xyz", "prn", "tsv"] {
        let path = put(&dir, &format!("t.{extension}"), rows("\t").join("\n").as_bytes());
        assert_upright(&read(&floats(&path), "probe").unwrap(), 0.01);
    }
}
