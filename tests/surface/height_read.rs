//! Every format: values, orientation, scale.

use crate::support::heights::*;
use diffraction_shaders::input::read_heights as read;
use diffraction_shaders::plan::{FileSource, Trust};
use diffraction_shaders::surface::read::Reading;
use diffraction_shaders::surface::{HeightField, write_gsf};
use image::ExtendedColorType;
use tiff::encoder::colortype;

/// Reads bytes under a name; integers with a full range of 0.51 µm (2 nm per grey step of 8 bits).
fn open(name: &str, bytes: &[u8]) -> Reading {
    let dir = folder();
    read(&integers(&put(&dir, name, bytes)), "probe").unwrap()
}

fn open_floats(name: &str, bytes: &[u8]) -> Reading {
    let dir = folder();
    read(&floats(&put(&dir, name, bytes)), "probe").unwrap()
}

fn values() -> Vec<f32> {
    greys().into_iter().map(|g| f32::from(g) / 100.0).collect()
}

#[test]
fn png_of_8_and_16_bits_uses_the_full_range() {
    assert_upright(&open("a.png", &grey_png()), 0.51 / 255.0);
    let wide: Vec<u8> =
        greys().into_iter().flat_map(|g| (u16::from(g) * 200).to_ne_bytes()).collect();
    let bytes = png(COLUMNS as u32, ROWS as u32, ExtendedColorType::L16, &wide);
    assert_upright(&open("a.PNG", &bytes), 200.0 * 0.51 / 65535.0);
}

#[test]
fn grey_colour_images_are_read_and_transparent_pixels_are_void() {
    let rgb: Vec<u8> = greys().into_iter().flat_map(|g| [g; 3]).collect();
    assert_upright(
        &open("a.png", &png(COLUMNS as u32, ROWS as u32, ExtendedColorType::Rgb8, &rgb)),
        0.51 / 255.0,
    );
    let mut rgba: Vec<u8> = greys().into_iter().flat_map(|g| [g, g, g, 255]).collect();
    rgba[4 * 6 + 3] = 0;
    let reading = open("a.png", &png(COLUMNS as u32, ROWS as u32, ExtendedColorType::Rgba8, &rgba));
    assert_eq!(reading.heights_um.iter().filter(|h| h.is_nan()).count(), 1);
    assert!(reading.heights_um[6].is_nan());
}

#[test]
fn tiff_of_integers_and_floats() {
    let (w, h) = (COLUMNS as u32, ROWS as u32);
    assert_upright(&open("a.tif", &tiff::<colortype::Gray8>(w, h, &greys())), 0.51 / 255.0);
    let wide: Vec<u16> = greys().into_iter().map(|g| u16::from(g) * 100).collect();
    assert_upright(
        &open("a.tiff", &tiff::<colortype::Gray16>(w, h, &wide)),
        100.0 * 0.51 / 65535.0,
    );
    assert_upright(&open_floats("a.tiff", &tiff::<colortype::Gray32Float>(w, h, &values())), 0.01);
}

#[test]
fn exr_of_one_or_several_equal_channels() {
    for compress in [false, true] {
        let single = exr(COLUMNS, ROWS, &[("height", values())], compress);
        assert_upright(&open_floats("a.exr", &single), 0.01);
    }
    let channels = [("R", values()), ("G", values()), ("B", values()), ("A", vec![1.0; 15])];
    assert_upright(&open_floats("a.exr", &exr(COLUMNS, ROWS, &channels, true)), 0.01);
}

#[test]
fn npy_of_both_widths_byte_orders_and_memory_orders() {
    let by_column = |row_major: &[f32]| -> Vec<f32> {
        (0..COLUMNS)
            .flat_map(|c| (0..ROWS).map(move |r| r * COLUMNS + c))
            .map(|i| row_major[i])
            .collect()
    };
    for fortran in [false, true] {
        let list = if fortran { by_column(&values()) } else { values() };
        let wide = || list.iter().map(|&v| f64::from(v));
        let files: [(&str, Vec<u8>); 4] = [
            ("<f4", list.iter().flat_map(|v| v.to_le_bytes()).collect()),
            (">f4", list.iter().flat_map(|v| v.to_be_bytes()).collect()),
            ("<f8", wide().flat_map(f64::to_le_bytes).collect()),
            (">f8", wide().flat_map(f64::to_be_bytes).collect()),
        ];
        for (descr, data) in files {
            assert_upright(&open_floats("a.npy", &npy_of(descr, fortran, "(3, 5)", &data)), 0.01);
        }
    }
    assert_upright(&open("a.npy", &npy_of("|u1", false, "(3, 5)", &greys())), 0.51 / 255.0);
    let profile = open_floats("a.npy", &npy_of("<f4", false, "(4,)", &[0; 16]));
    assert_eq!((profile.columns, profile.rows), (4, 1));
}

#[test]
fn gsf_carries_its_own_scale_with_oblong_pixels() {
    let metres: Vec<f32> = greys().into_iter().map(|g| f32::from(g) * 1e-9).collect();
    // titles of four lengths run through every amount of padding
    for title in ["", "a", "ab", "abc"] {
        let header = format!(
            r#"XRes = 5
YRes = 3
XReal = 1e-6
YReal=3e-7
ZUnits = m
Title = {title}
"#
        );
        let dir = folder();
        let source =
            FileSource { pixel_um: None, ..floats(&put(&dir, "a.gsf", &gsf(&header, &metres))) };
        let reading = read(&source, "probe").unwrap();
        assert_upright(&reading, 0.001);
        assert!(
            (reading.pitch_x_um - 0.2).abs() < 1e-12 && (reading.pitch_y_um - 0.1).abs() < 1e-12
        );
        assert!(reading.notes.is_empty(), "{:?}", reading.notes);
    }
}

#[test]
fn a_scale_in_the_plan_contradicts_that_of_a_gsf_or_is_trusted() {
    let dir = folder();
    let header = r#"XRes = 5
YRes = 3
XReal = 1e-6
YReal = 3e-7
XYUnits = m
ZUnits = m
"#;
    let path = put(&dir, "a.gsf", &gsf(header, &[0.0; 15]));
    let wide = FileSource { size_um: Some(2.0), ..bare(&path) };
    assert_says(
        read(&wide, "probe"),
        &["size_um = 2", "2 × 0.6 µm", "1 × 0.3 µm", "XReal", "trust = \"plan\""],
    );
    let trusted = |source: FileSource| {
        let reading = read(&FileSource { trust: Trust::Plan, ..source }, "probe").unwrap();
        assert!(reading.notes.iter().any(|n| n.contains("trust")), "{:?}", reading.notes);
        (reading.pitch_x_um, reading.pitch_y_um)
    };
    let close = |(x, y): (f64, f64), wanted: (f64, f64)| {
        assert!((x - wanted.0).abs() < 1e-12 && (y - wanted.1).abs() < 1e-12, "{x} {y}");
    };
    // the width alone keeps the file's aspect, the pitch makes pixels square
    close(trusted(wide), (0.4, 0.2));
    let square = FileSource { pixel_um: Some(0.3), ..bare(&path) };
    assert_says(read(&square, "probe"), &["pixel_um = 0.3", "0.2 × 0.1 µm"]);
    close(trusted(square), (0.3, 0.3));
    let unit = FileSource { z_unit_um: Some(1.0), ..bare(&path) };
    assert_says(read(&unit, "probe"), &["z_unit_um = 1", "1000000 µm per unit", "ZUnits"]);
    trusted(unit);
    // within a percent there is no contradiction, and the plan's number is used
    let close_by = FileSource { size_um: Some(1.004), ..bare(&path) };
    let reading = read(&close_by, "probe").unwrap();
    assert!(reading.notes.is_empty(), "{:?}", reading.notes);
    close((reading.pitch_x_um, reading.pitch_y_um), (0.2008, 0.1004));
}

#[test]
fn a_written_gsf_reads_back() {
    for columns in 2..7 {
        let heights: Vec<f64> = (0..columns * 3).map(|i| 0.01 * (i * i) as f64).collect();
        let field = HeightField::new(columns, 3, 0.05, 0.075, heights).unwrap();
        let dir = folder();
        let path = put(&dir, "a.gsf", &write_gsf(&field));
        let back = read(&FileSource { pixel_um: None, ..floats(&path) }, "probe").unwrap();
        assert_eq!((back.columns, back.rows), (columns, 3));
        assert!((back.pitch_x_um - 0.05).abs() < 1e-12 && (back.pitch_y_um - 0.075).abs() < 1e-12);
        for (a, b) in back.heights_um.iter().zip(field.heights_um()) {
            assert!((a - b).abs() < 1e-7, "{a} {b}");
        }
    }
}

#[test]
fn text_with_every_separator() {
    let line = |row: usize, between: &str| {
        (0..COLUMNS)
            .map(|c| (f32::from(grey(c, row)) / 100.0).to_string())
            .collect::<Vec<_>>()
            .join(between)
    };
    for between in [" ", "  ", "\t", ",", ", ", ";", " ; "] {
        let text = format!(
            "# heights\r\n{}\r\n\r\n {} # middle\n\n{}",
            line(0, between),
            line(1, between),
            line(2, between)
        );
        assert_upright(&open_floats("a.csv", text.as_bytes()), 0.01);
    }
    assert_eq!(
        open_floats("a.txt", b"\xef\xbb\xbf1e-1 2\n-3 nan\n").heights_um[..3],
        [0.1, 2.0, -3.0]
    );
}

#[test]
fn float_units_and_sizes() {
    let dir = folder();
    let path = put(&dir, "a.txt", b"0 100 200 300\n400 500 600 700\n");
    let source =
        FileSource { size_um: Some(2.0), pixel_um: None, z_unit_um: Some(0.001), ..floats(&path) };
    let reading = read(&source, "probe").unwrap();
    assert_eq!((reading.pitch_x_um, reading.pitch_y_um), (0.5, 0.5));
    assert!((reading.heights_um[7] - 0.7).abs() < 1e-12);
    // of a profile, the size is its length whichever way it lies
    let column = put(&dir, "b.txt", b"0\n1\n2\n3\n");
    let reading =
        read(&FileSource { size_um: Some(2.0), pixel_um: None, ..floats(&column) }, "probe")
            .unwrap();
    assert_eq!((reading.columns, reading.rows, reading.pitch_y_um), (1, 4, 0.5));
}

#[test]
fn heights_that_look_like_metres_are_noted() {
    let reading = open_floats("a.txt", b"0 1e-7\n2e-7 3e-7\n");
    let says = |n: &String| n.contains("numbers are in m, write z_unit_um = 1000000");
    assert!(reading.notes.iter().any(says), "{:?}", reading.notes);
}
