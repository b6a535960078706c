//! What headers of text files state is used: sizes, units, numbers of pixels.

use crate::support::heights::*;
use diffraction_shaders::input::read_heights as read;
use diffraction_shaders::plan::{FileSource, Trust};
use diffraction_shaders::surface::read::Reading;

fn open(bytes: impl AsRef<[u8]>) -> Reading {
    let dir = folder();
    read(&bare(&put(&dir, "a.txt", bytes.as_ref())), "probe").unwrap()
}

fn refuse(bytes: impl AsRef<[u8]>, keys: FileSource, parts: &[&str]) {
    let dir = folder();
    let path = put(&dir, "a.txt", bytes.as_ref());
    assert_says(read(&FileSource { path, ..keys }, "probe"), parts);
}

#[track_caller]
fn assert_pitch(reading: &Reading, x: f64, y: f64) {
    let found = (reading.pitch_x_um, reading.pitch_y_um);
    assert!((found.0 / x - 1.0).abs() < 1e-9 && (found.1 / y - 1.0).abs() < 1e-9, "{found:?}");
}

fn matrix() -> String {
    rows("\t").join("\n")
}

/// 5 × 3 pixels of 0.5 × 0.25 µm with heights in nm, as each program writes it.
#[test]
fn headers_of_programs() {
    let micro = '\u{b5}';
    let headers = [
        format!("# Channel: Topo\n# Width: 2.500 {micro}m\n# Height: 750.0 nm\n# Value units: nm"),
        format!("# Kanal: Topo\n# Breite: 2,500 {micro}m\n# Höhe: 0,750 \u{3bc}m\n# Einheiten: nm"),
        "# File Format = ASCII\n# Created by SPIP\n# x-pixels = 5\n# y-pixels = 3\n# x-length = 2500\n# y-length = 750\n# x-offset = 0\n# z-unit = nm\n# voidpixels =0\n# Start of Data:".to_owned(),
        "# File Format = ASCII\n# x-pixels = 5\n# y-pixels = 3\n# x-length = 2500\n# y-length = 750\n# Bit2nm = 1.0\n# Start of Data:".to_owned(),
        "# Daisy frame view snapshot\n# 2009-07-14T10:12:34\n# x-pixels: 5\n# y-pixels: 3\n# x-length: 2.5\n# y-length: 0.75\n# x-unit: um\n# y-unit: um\n# z-unit: nm\n# display: Topography\n# Start of Data:".to_owned(),
        "File Format = ASCII\nCreated by Nova\nNX = 5\nNY = 3\nScale X = 0.5\nScale Y = 0.25\nUnit X = um\nUnit Data = nm\nScale Data = 7\nDataScaleNeeded = no\nStart of Data :".to_owned(),
        format!("WSxM file copyright UAM\nWSxM ASCII Matrix file\nX Amplitude: 2.5 {micro}m\nY Amplitude: 750 nm\nZ Amplitude: 0.92 nm"),
        "% scanned by hand\n% pixel size x = 500 nanometres\n% pixel size y = 10^-6 m\n% units: Nanometers".replace("10^-6 m", "0.25 micron"),
        "\\*File list\n\\Date: 1\n\\Samps/line: 5\n\\Lines: 3\n\\Scan Size: 2.5 0.75 ~m\nHeight_Sensor(nm)".to_owned(),
    ];
    for header in headers {
        let reading = open(format!("{header}\n{}\n", matrix()));
        assert_upright(&reading, 1e-5);
        assert_pitch(&reading, 0.5, 0.25);
    }
    // without the header the same numbers are µm, and have no scale
    refuse(matrix(), FileSource::default(), &["no physical scale", "size_um"]);
}

#[test]
fn units_of_heights() {
    for (word, um) in [
        ("m", 1e6),
        ("mm", 1e3),
        ("µm", 1.0),
        ("\u{3bc}m", 1.0),
        ("micron", 1.0),
        ("nm", 1e-3),
        ("nanometers", 1e-3),
        ("nanometres", 1e-3),
        ("Å", 1e-4),
        ("Angstrom", 1e-4),
        ("pm", 1e-6),
        ("10^-9 m", 1e-3),
    ] {
        let small = rows(" ").join("\n").replace("0.", "0.00000").replace("1.", "0.00001");
        let text = format!("# Width: 2.5 µm\n# Value units: {word}\n{small}\n");
        let low = open(text).heights_um[0];
        assert!((low / (0.07e-5 * um) - 1.0).abs() < 1e-9, "{word}: {low}");
    }
    for (word, shown) in [("deg", "deg"), ("V", "V"), ("", "no unit"), ("A", "A")] {
        let text = format!("# Width: 2.5 µm\n# Value units: {word}\n{}\n", matrix());
        refuse(&text, FileSource::default(), &[shown, "not a unit of length", "z_unit_um"]);
        // the plan may know better
        let dir = folder();
        let path = put(&dir, "a.txt", text.as_bytes());
        let reading = read(&FileSource { z_unit_um: Some(0.01), ..bare(&path) }, "probe").unwrap();
        assert_upright(&reading, 1e-4);
    }
}

#[test]
fn a_plan_that_contradicts_a_header_is_refused_or_trusted() {
    let text = format!("# Width: 2.50 µm\n# Height: 0.75 µm\n# Value units: nm\n{}\n", matrix());
    let wide = FileSource { size_um: Some(25.0), ..FileSource::default() };
    let words =
        ["size_um = 25", "25 × 7.5 µm", "2.5 × 0.75 µm", "Width: 2.50 µm", "trust = \"plan\""];
    refuse(&text, wide.clone(), &words);
    let tall = FileSource { size_um: Some(2.5), size_y_um: Some(1.0), ..FileSource::default() };
    refuse(&text, tall.clone(), &["size_y_um = 1", "2.5 × 1 µm", "2.5 × 0.75 µm"]);
    let micro = FileSource { z_unit_um: Some(1.0), ..FileSource::default() };
    refuse(
        &text,
        micro.clone(),
        &["z_unit_um = 1", "0.001 µm per unit", "Value units: nm", "trust"],
    );
    let dir = folder();
    let path = put(&dir, "a.txt", text.as_bytes());
    for (source, pitch, unit) in
        [(wide, (5.0, 2.5), 1e-5), (tall, (0.5, 1.0 / 3.0), 1e-5), (micro, (0.5, 0.25), 1e-2)]
    {
        let source = FileSource { path: path.clone(), trust: Trust::Plan, ..source };
        let reading = read(&source, "probe").unwrap();
        assert_upright(&reading, unit);
        assert_pitch(&reading, pitch.0, pitch.1);
        assert!(reading.notes.iter().any(|n| n.contains("trust")), "{:?}", reading.notes);
    }
    // headers are rounded: a percent is no contradiction, two are
    for (size, is_sound) in [(2.52, true), (2.48, true), (2.54, false), (2.46, false)] {
        let source = FileSource { size_um: Some(size), ..bare(&path) };
        assert_eq!(read(&source, "probe").is_ok(), is_sound, "{size}");
    }
}

#[test]
fn lengths_without_a_unit_need_the_plan() {
    let text = format!(
        "ncols 5\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 50\nNODATA_value -9999\n{}\n",
        matrix()
    );
    refuse(&text, FileSource::default(), &["no physical scale", "cellsize: 50", "without a unit"]);
    let dir = folder();
    let path = put(&dir, "a.asc", text.as_bytes());
    let reading = read(&FileSource { pixel_um: Some(0.05), ..bare(&path) }, "probe").unwrap();
    assert_upright(&reading, 0.01);
    assert_pitch(&reading, 0.05, 0.05);
    assert!(reading.notes.iter().any(|n| n.contains("taken as nm")), "{:?}", reading.notes);
    let other = FileSource { pixel_um: Some(0.07), ..bare(&path) };
    assert_says(read(&other, "probe"), &["pixel_um = 0.07", "cellsize", "50 per pixel", "trust"]);
    // a width that is the number of columns is no length
    let counted = format!("# Width: 5\n# Height: 3\n{}\n", matrix());
    let path = put(&dir, "b.txt", counted.as_bytes());
    let reading = read(&floats(&path), "probe").unwrap();
    assert_pitch(&reading, 0.1, 0.1);
}

#[test]
fn a_stated_number_of_pixels_makes_lines_irrelevant() {
    let header =
        "# x-pixels = 5\n# y-pixels = 3\n# x-length = 2500\n# y-length = 750\n# z-unit = nm\n";
    let one_line = rows(" ").join(" ");
    let one_column = rows("\n").join("\n");
    let wrapped: String = one_line
        .split(' ')
        .enumerate()
        .map(|(i, n)| if i % 4 == 3 { format!("{n}\n") } else { format!("{n} ") })
        .collect();
    for body in [one_line, one_column, wrapped] {
        let reading = open(format!("{header}{body}\n"));
        assert_upright(&reading, 1e-5);
        assert_pitch(&reading, 0.5, 0.25);
    }
    let short = format!("{header}{}\n", rows(" ")[..2].join("\n"));
    refuse(short, FileSource::default(), &["5 × 3 pixels", "10 numbers", "truncated"]);
}

#[test]
fn formats_of_zygo_and_surfer() {
    let phases: Vec<String> = greys().iter().map(|g| (u32::from(*g) * 100).to_string()).collect();
    let header = |kind: &str| {
        format!(
            "Zygo {kind} Data File - Format 2\n1 8 3 5 \"Thu\"\n0 0 0 0 0 0\n0 0 5 3\n\"c\"\n\"s\"\n\"p\"\n0 0.5 6.328e-07 0 1 0 5e-07 1\n5 3 0 0 0 0 \"o\"\n0 0 0 0 0 0 0 0 0 0\n1 1 20 2 0 0 0 0 0\n0 \"x\"\n1 0\n\"l\"\n#\n"
        )
    };
    // half a wave of 632.8 nm in 32768 steps
    let step = 0.5 * 0.6328 / 32768.0;
    let ascii = header("ASCII") + &phases.join(" ") + "\n#\n";
    let reading = open(&ascii);
    assert_upright(&reading, 100.0 * step);
    assert_pitch(&reading, 0.5, 0.5);
    let holes = open(ascii.replacen(" 1000 ", " 2147483640 ", 1));
    assert!(holes.heights_um[1].is_nan() && !holes.heights_um[0].is_nan());
    refuse(
        header("ASCII") + &phases[1..].join(" ") + "\n#\n",
        FileSource::default(),
        &["Zygo", "number of phases"],
    );
    let pixels: String = (0..15)
        .map(|i| format!("{} {} {}\n", i % 5, i / 5, f64::from(greys()[i]) / 100.0))
        .collect();
    let xyz = header("XYZ") + &pixels.replacen("1 0 0.1\n", "1 0 No Data\n", 1) + "#\n";
    let reading = open(&xyz);
    assert!(reading.heights_um[1].is_nan());
    assert!((reading.heights_um[5] - 0.47).abs() < 1e-12);
    assert_pitch(&reading, 0.5, 0.5);

    let upwards: Vec<String> = rows(" ").into_iter().rev().collect();
    let grid = format!("DSAA\n5 3\n0 2\n0 0.5\n0 1\n{}\n", upwards.join("\n"));
    let dir = folder();
    let path = put(&dir, "a.grd", grid.as_bytes());
    let reading = read(&FileSource { size_um: Some(2.5), ..bare(&path) }, "probe").unwrap();
    assert_upright(&reading, 0.01);
    assert_pitch(&reading, 0.5, 0.25);
    refuse(&grid[..grid.len() - 8], FileSource::default(), &["Surfer", "fewer"]);
}

#[test]
fn named_columns_with_a_stated_number_of_pixels() {
    let lines: String =
        greys().iter().map(|g| format!("{}\t{:.2}\n", 255 - g, f64::from(*g) / 100.0)).collect();
    let text = format!(
        "\"\\Samps/line: 5\"\n\"\\Lines: 3\"\n\"\\Scan Size: 500 nm\"\nPhase(deg)\tHeight_Sensor(nm)\n{lines}"
    );
    let dir = folder();
    let path = put(&dir, "a.txt", text.as_bytes());
    let reading = read(&bare(&path), "probe").unwrap();
    assert_upright(&reading, 1e-5);
    let by_name = FileSource { channel: Some("phase".into()), ..bare(&path) };
    assert_says(read(&by_name, "probe"), &["deg", "not a unit of length"]);
    let absent = FileSource { channel: Some("Adhesion".into()), ..bare(&path) };
    assert_says(read(&absent, "probe"), &["Adhesion", "Phase, Height_Sensor"]);
}
