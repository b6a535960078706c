//! Numbers that stand for no height, and heights that make no sense.

use crate::support::heights::*;
use diffraction_shaders::error::Result;
use diffraction_shaders::input::read_heights as read;
use diffraction_shaders::plan::{FileSource, VoidValue};
use diffraction_shaders::surface::read::Reading;
use image::ExtendedColorType;

fn open(text: &str, void: Option<VoidValue>) -> Result<Reading> {
    let dir = folder();
    let path = put(&dir, "a.txt", text.as_bytes());
    read(&FileSource { void_value: void, z_unit_um: Some(1e-3), ..floats(&path) }, "probe")
}

fn holes(reading: &Reading) -> Vec<usize> {
    (0..reading.heights_um.len()).filter(|&i| reading.heights_um[i].is_nan()).collect()
}

#[test]
fn marks_are_asked_about_and_then_void() {
    for mark in [
        "-9999",
        "-99999",
        "-32768",
        "32767",
        "2147483647",
        "2147483640",
        "1.70141e38",
        "3.4028234663852886e38",
        "-1e30",
        "65535",
    ] {
        let text = format!("10 20 {mark}\n40 {mark} 60\n15 25 37\n");
        let shown: f64 = mark.parse().unwrap();
        let value = format!("void_value = {shown}");
        assert_says(open(&text, None), &["2 pixels are", &value, "\"none\""]);
        let reading = open(&text, Some(VoidValue::Number(shown))).unwrap();
        assert_eq!(holes(&reading), [2, 4], "{mark}");
        assert!((reading.heights_um[0] - 0.01).abs() < 1e-12);
        let says = |n: &String| n.contains("2 pixels") && n.contains("void_value");
        assert!(reading.notes.iter().any(says), "{:?}", reading.notes);
    }
    // a header that names the mark is enough
    let stated = "ncols 3\nnrows 2\nNODATA_value -9999\n10 20 -9999\n40 50 60\n";
    assert_eq!(holes(&open(stated, None).unwrap()), [2]);
    // and the plan may call it a height
    let height = open("10 20 32767\n40 50 60\n", Some(VoidValue::None)).unwrap();
    assert!(holes(&height).is_empty() && (height.heights_um[2] - 32.767).abs() < 1e-9);
}

#[test]
fn heights_that_only_look_like_marks_stay() {
    for text in [
        "30000 32767\n31000 32000\n",
        "-9999 -9990\n-9980 -9950\n",
        "10 20\n40 9998\n",
        "0 0\n0 0\n",
    ] {
        assert!(holes(&open(text, None).unwrap()).is_empty(), "{text}");
    }
}

/// White that lies far from greys with many levels is a mark; white of a drawing is none.
#[test]
fn marks_of_integer_files() {
    let dir = folder();
    let png16 = |values: &[u16]| {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_ne_bytes()).collect();
        put(&dir, "a.png", &png(8, 4, ExtendedColorType::L16, &bytes))
    };
    let mut values: Vec<u16> = (0..32).map(|i| 1000 + 7 * i).collect();
    assert!(read(&integers(&png16(&values)), "probe").is_ok());
    values[5] = 65535;
    let path = png16(&values);
    assert_says(read(&integers(&path), "probe"), &["1 pixels are 65535", "void_value = 65535"]);
    let marked = FileSource { void_value: Some(VoidValue::Number(65535.0)), ..integers(&path) };
    assert_eq!(holes(&read(&marked, "probe").unwrap()), [5]);
    let drawing: Vec<u16> = (0..32).map(|i| if i % 3 == 0 { 65535 } else { 100 }).collect();
    assert!(read(&integers(&png16(&drawing)), "probe").is_ok());
}

#[test]
fn reliefs_that_make_no_sense_are_warned_about() {
    let dir = folder();
    let notes = |scale: f64, keys: FileSource| {
        let text: String = (0..8)
            .map(|r| {
                (0..8)
                    .map(|c| format!("{:e} ", scale * f64::from((r * c) % 5) / 4.0))
                    .collect::<String>()
                    + "\n"
            })
            .collect();
        let path = put(&dir, "a.txt", text.as_bytes());
        read(&FileSource { path, pixel_um: Some(0.1), ..keys }, "probe").unwrap().notes.join("\n")
    };
    let none = FileSource::default;
    assert!(
        notes(1e-4, none()).contains("0.1 nm")
            && notes(1e-4, none()).contains("in mm, write z_unit_um = 1000")
    );
    assert!(notes(1e-7, none()).contains("in m, write z_unit_um = 1000000"));
    let high = notes(80.0, none());
    assert!(high.contains("80 µm") && high.contains("in nm, write z_unit_um = 0.001"), "{high}");
    let steep = notes(15.0, none());
    assert!(steep.contains("steeper") && steep.contains("nm, write z_unit_um = 0.001"), "{steep}");
    // a relief of a few hundred nanometres is none of these, whichever way it is written
    assert_eq!(notes(0.2, none()), "");
    assert_eq!(notes(200.0, FileSource { z_unit_um: Some(1e-3), ..none() }), "");
    // and upright walls of a grating are few
    let wall: String = (0..8).map(|_| "0 0 0 0 0.4 0.4 0.4 0.4\n").collect();
    let path = put(&dir, "b.txt", wall.as_bytes());
    let source = FileSource { pixel_um: Some(0.02), ..bare(&path) };
    assert!(read(&source, "probe").unwrap().notes.is_empty());
}
