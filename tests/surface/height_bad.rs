//! Bad input: an error that names the surface, the file, the value and the remedy; never a crash.

use crate::support::heights::*;
use diffraction_shaders::error::Result;
use diffraction_shaders::input::read_heights as read;
use diffraction_shaders::plan::FileSource;
use diffraction_shaders::surface::read::Reading;
use image::ExtendedColorType;
use tiff::encoder::colortype;

fn open(name: &str, bytes: &[u8]) -> Result<Reading> {
    let dir = folder();
    read(&floats(&put(&dir, name, bytes)), "probe")
}

fn open_integers(name: &str, bytes: &[u8]) -> Result<Reading> {
    let dir = folder();
    read(&integers(&put(&dir, name, bytes)), "probe")
}

#[test]
fn files_that_are_none() {
    let dir = folder();
    let missing = read(&floats(&dir.path().join("gone.png")), "probe");
    assert_says(
        missing,
        &["surface probe", "gone.png", "cannot be read", "relative to the folder"],
    );
    let folder_path = dir.path().join("scan.png");
    std::fs::create_dir(&folder_path).unwrap();
    assert_says(read(&floats(&folder_path), "probe"), &["scan.png", "not a regular file"]);
    assert_says(open("a.png", b""), &["a.png", "empty"]);
    assert_says(open("a.jpg", b"\xff\xd8\xff"), &["`jpg`", "png", "gsf"]);
    assert_says(open("noextension", b"1 2\n"), &["extension"]);
}

#[test]
fn content_must_match_the_extension() {
    assert_says(open_integers("a.tif", &grey_png()), &["PNG", "`tif`", "TIFF", "rename"]);
    assert_says(open_integers("a.txt", &grey_png()), &["PNG", "`txt`"]);
    assert_says(open("a.png", b"1 2\n3 4\n"), &["text", "`png`"]);
    assert_says(open("a.npy", b"\x00\x01\x02\x03 garbage"), &["not NPY", "has the wrong name"]);
    assert_says(open("a.gsf", &npy_of("<f4", false, "(1, 1)", &[0; 4])), &["NPY", "`gsf`"]);
}

/// Every file, cut at every length, must be an error, or (where only trailing bytes are missing) be read; never a crash.
#[test]
fn truncated_files() {
    let ramp: Vec<f32> = (0..60).map(|i| i as f32 * 0.01).collect();
    let bytes: Vec<u8> = ramp.iter().flat_map(|v| v.to_le_bytes()).collect();
    let noise: Vec<u8> = (0..60u32).map(|i| (i * 97 % 251) as u8).collect();
    let files = [
        ("a.png", png(10, 6, ExtendedColorType::L8, &noise)),
        ("b.tif", tiff::<colortype::Gray8>(10, 6, &noise)),
        ("c.tif", tiff::<colortype::Gray32Float>(10, 6, &ramp)),
        ("d.exr", exr(10, 6, &[("Y", ramp.clone())], false)),
        ("e.exr", exr(10, 6, &[("Y", ramp.clone())], true)),
        ("f.npy", npy_of("<f4", false, "(6, 10)", &bytes)),
        (
            "g.gsf",
            gsf(
                r#"XRes = 10
YRes = 6
XReal = 1e-6
YReal = 6e-7
ZUnits = m
"#,
                &[1e-7; 60],
            ),
        ),
    ];
    for (name, whole) in files {
        let source =
            |path: &std::path::Path| if name < "c" { integers(path) } else { floats(path) };
        let dir = folder();
        read(&source(&put(&dir, name, &whole)), "probe").unwrap();
        for length in 0..whole.len() - 16 {
            let result = read(&source(&put(&dir, name, &whole[..length])), "probe");
            let text = match result {
                // the image of a PNG can be complete before its last chunks are
                Ok(_) if name == "a.png" && length + 24 > whole.len() => continue,
                // a TIFF's directory may come first and its data last, or the other way round
                Ok(reading) => panic!("{name} cut at {length} of {}: {reading:?}", whole.len()),
                Err(error) => error.to_string(),
            };
            assert!(text.contains(name), "{text}");
        }
    }
}

/// One byte wrong anywhere: read or refused, never a crash.
#[test]
fn damaged_files_do_not_crash() {
    let ramp: Vec<f32> = (0..12).map(|i| i as f32 * 0.01).collect();
    let bytes: Vec<u8> = ramp.iter().flat_map(|v| v.to_le_bytes()).collect();
    let files = [
        ("a.png", png(4, 3, ExtendedColorType::L8, &[9; 12])),
        ("b.tif", tiff::<colortype::Gray8>(4, 3, &[9; 12])),
        ("c.exr", exr(4, 3, &[("Y", ramp.clone())], true)),
        ("d.npy", npy_of("<f4", true, "(3, 4)", &bytes)),
        ("e.gsf", gsf("XRes = 4\nYRes = 3\n", &[1e-7; 12])),
    ];
    for (name, whole) in files {
        let dir = folder();
        let mut refused = 0;
        for at in 0..whole.len() {
            for flip in [0x01, 0x80, 0xff] {
                let mut damaged = whole.clone();
                damaged[at] ^= flip;
                let path = put(&dir, name, &damaged);
                refused += usize::from(read(&integers(&path), "probe").is_err());
                refused += usize::from(read(&floats(&path), "probe").is_err());
            }
        }
        assert!(refused > 0, "{name}");
    }
}

#[test]
fn announced_sizes_are_checked_before_allocating() {
    let huge = npy_of("<f8", false, "(20000, 20000)", &[0; 64]);
    assert_says(open("a.npy", &huge), &["20000 × 20000", "limit", "16384"]);
    let overflow = npy_of("<f8", false, "(18446744073709551615, 18446744073709551615)", &[0; 64]);
    assert_says(open("a.npy", &overflow), &["limit"]);
    assert_says(
        open("a.npy", &npy_of("<f8", false, "(8000, 8000)", &[0; 64])),
        &["512000000 bytes", "64", "truncated"],
    );
    assert_says(
        open("a.gsf", &gsf("XRes = 20000\nYRes = 20000\n", &[])),
        &["20000 × 20000", "limit"],
    );
    assert_says(
        open("a.gsf", &gsf("XRes = 8000\nYRes = 8000\n", &[])),
        &["256000000 bytes", "truncated"],
    );
    // width and height of a PNG lie at bytes 16 to 24, and its checksum over them at 29
    for (side, part) in [(20000u32, "limit"), (8000, "declares")] {
        let mut bytes = grey_png();
        bytes[16..20].copy_from_slice(&side.to_be_bytes());
        bytes[20..24].copy_from_slice(&side.to_be_bytes());
        let crc = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&crc.to_be_bytes());
        assert_says(open_integers("a.png", &bytes), &["a.png", part]);
    }
    // a directory whose width and height say 8000, with three bytes of pixels
    let mut bytes = tiff::<colortype::Gray8>(3, 1, &[1, 2, 3]);
    let directory = u32::from_le_bytes(bytes[4..8].try_into().unwrap()) as usize;
    for entry in bytes[directory + 2..].chunks_exact_mut(12) {
        if matches!(u16::from_le_bytes([entry[0], entry[1]]), 256 | 257) {
            entry[8..10].copy_from_slice(&8000u16.to_le_bytes());
        }
    }
    assert_says(open_integers("a.tif", &bytes), &["a.tif", "64000000 bytes"]);
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &b| {
        (0..8).fold(
            crc ^ u32::from(b),
            |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 },
        )
    })
}

#[test]
fn colour_is_refused_with_its_place() {
    let mut rgb: Vec<u8> = greys().into_iter().flat_map(|g| [g; 3]).collect();
    rgb[3 * 8 + 1] ^= 1;
    let bytes = png(COLUMNS as u32, ROWS as u32, ExtendedColorType::Rgb8, &rgb);
    assert_says(
        open_integers("a.png", &bytes),
        &["column 3, row 1", "coloured", "56, 57, 56", "grey"],
    );
    let bytes = tiff::<colortype::RGB8>(COLUMNS as u32, ROWS as u32, &rgb);
    assert_says(open_integers("a.tif", &bytes), &["column 3, row 1"]);
    let half: Vec<u8> =
        greys().into_iter().flat_map(|g| [g, if g == 50 { 128 } else { 255 }]).collect();
    let bytes = png(COLUMNS as u32, ROWS as u32, ExtendedColorType::La8, &half);
    assert_says(open_integers("a.png", &bytes), &["column 1, row 1", "transparent"]);
    let channels = [("R", vec![0.1, 0.2]), ("G", vec![0.1, 0.3])];
    assert_says(open("a.exr", &exr(2, 1, &channels, false)), &["G and R", "column 1, row 0"]);
}

#[test]
fn height_keys_belong_to_their_kind_of_file() {
    assert_says(open("a.png", &grey_png()), &["`height_um` is missing", "8-bit", "0…255"]);
    let dir = folder();
    let path = put(&dir, "a.png", &grey_png());
    assert_says(
        read(&FileSource { z_unit_um: Some(1.0), ..integers(&path) }, "probe"),
        &["z_unit_um = 1", "height_um"],
    );
    assert_says(
        open_integers("a.txt", b"1 2\n3 4\n"),
        &["height_um = 0.51", "floats", "µm", "z_unit_um"],
    );
}

#[test]
fn lengths_must_make_sense() {
    let dir = folder();
    let path = put(&dir, "a.txt", b"1 2\n3 4\n");
    let picture = put(&dir, "a.png", &grey_png());
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let value = format!("= {bad}`");
        let size = FileSource { size_um: Some(bad), pixel_um: None, ..floats(&path) };
        assert_says(read(&size, "probe"), &["a.txt", "`size_um", &value]);
        assert_says(
            read(&FileSource { pixel_um: Some(bad), ..floats(&path) }, "probe"),
            &["`pixel_um", &value],
        );
        assert_says(
            read(&FileSource { z_unit_um: Some(bad), ..floats(&path) }, "probe"),
            &["`z_unit_um", &value],
        );
        assert_says(
            read(&FileSource { height_um: Some(bad), ..floats(&picture) }, "probe"),
            &["`height_um", &value],
        );
    }
    assert_says(
        read(&FileSource { height_um: Some(375.0), ..floats(&picture) }, "probe"),
        &["375", "100 µm", "nm"],
    );
    assert_says(
        read(&FileSource { pixel_um: Some(5000.0), ..floats(&path) }, "probe"),
        &["pixel_um = 5000", "nm"],
    );
    let tiny = FileSource { size_um: Some(6.5e-8), pixel_um: None, ..floats(&path) };
    assert_says(read(&tiny, "probe"), &["size_um = 0.000000065", "m or mm"]);
    assert_says(
        read(&FileSource { size_um: Some(1.0), ..floats(&path) }, "probe"),
        &["both", "size_um", "pixel_um"],
    );
    let none = FileSource { pixel_um: None, ..floats(&path) };
    assert_says(read(&none, "probe"), &["no physical scale", "size_um", "pixel_um"]);
    assert_says(open("a.txt", b"0 375\n1 2\n"), &["375", "100 µm", "z_unit_um = 0.001"]);
}

#[test]
fn text_errors_have_lines() {
    assert_says(open("a.txt", b"# c\n1 2 3\n4 5\n"), &["line 3 has 2", "line 2 has 3"]);
    assert_says(open("a.csv", b"1,2.5\nx,y\n"), &["line 2", "`x,y`", "not a number", "#"]);
    assert_says(open("a.csv", b"1,2\n3,\n"), &["line 2", "field 2 is empty", "nan"]);
    assert_says(open("a.txt", b"1 2\n3 \xff\n"), &["line 2", "not a number"]);
    assert_says(open("a.txt", b"# 1 2 3\n"), &["no numbers"]);
    assert_says(open("a.txt", b"1 2\ninf 4\n"), &["column 0, row 1", "inf"]);
}

#[test]
fn gsf_errors() {
    assert_says(open("a.gsf", &gsf("XRes = 2\n", &[0.0; 4])), &["no `YRes`"]);
    assert_says(
        open("a.gsf", &gsf("XRes = two\nYRes = 2\n", &[0.0; 4])),
        &["line 2", "two", "whole number"],
    );
    assert_says(open("a.gsf", &gsf("XRes = 0\nYRes = 2\n", &[])), &["0 × 2"]);
    assert_says(
        open(
            "a.gsf",
            &gsf(
                r#"XRes = 2
YRes = 2
XReal = -1
"#,
                &[0.0; 4],
            ),
        ),
        &["XReal = -1"],
    );
    assert_says(
        open(
            "a.gsf",
            &gsf(
                r#"XRes = 2
YRes = 2
nonsense
"#,
                &[0.0; 4],
            ),
        ),
        &["line 4", "nonsense"],
    );
    assert_says(open("a.gsf", &gsf("XRes = 2\nYRes = 2\n", &[0.0; 5])), &["16 bytes", "20"]);
    assert_says(
        open(
            "a.gsf",
            &gsf(
                r#"XRes = 2
YRes = 2
ZUnits = V
"#,
                &[0.0; 4],
            ),
        ),
        &["not a unit of length", "z_unit_um"],
    );
    assert_says(open("a.gsf", b"Gwyddion Simple Field 1.0\nXRes = 2\n"), &["NUL"]);
}

#[test]
fn exr_tiles_are_checked_before_allocating() {
    let mut bytes = include_bytes!("../../fuzz/seeds/exr/tiles.exr").to_vec();
    let mark = b"tiles\0tiledesc\0";
    let at = bytes.windows(mark.len()).position(|window| window == mark).unwrap();
    // after the length of the attribute, 4 bytes
    let width = at + mark.len() + 4;
    bytes[width..width + 4].copy_from_slice(&0x3a00_0002u32.to_le_bytes());
    assert_says(open("a.exr", &bytes), &["tiles of 973078530 × 2 pixels for a layer of 5 × 3"]);
}

#[test]
fn exr_chunks_of_another_level_are_refused() {
    let mut bytes = include_bytes!("../../fuzz/seeds/exr/tiles.exr").to_vec();
    let mark = b"tiles\0tiledesc\0";
    let at = bytes.windows(mark.len()).position(|window| window == mark).unwrap();
    // length, description of 9 bytes, end of the header; then places of chunks, each with column, row, level x, level y
    let table = at + mark.len() + 4 + 9 + 1;
    let chunk = u64::from_le_bytes(bytes[table..table + 8].try_into().unwrap()) as usize;
    bytes[chunk + 12..chunk + 16].copy_from_slice(&16u32.to_le_bytes());
    assert_says(open("a.exr", &bytes), &["points to other layers or levels"]);
}

#[test]
fn npy_errors() {
    assert_says(open("a.npy", &npy_of("<f8", false, "(2, 2, 2)", &[0; 64])), &["3 dimensions"]);
    assert_says(open("a.npy", &npy_of("<i4", false, "(2, 2)", &[0; 16])), &["<i4", "float32"]);
    assert_says(open("a.npy", &npy_of("<f8", false, "(0, 2)", &[])), &["no heights"]);
    assert_says(open("a.npy", &npy("{'descr': '<f8'}", &[])), &["shape"]);
    // the parser of headers takes a multiple of the time for every bracket within another
    let nested = format!("{{'descr': '<f8', 'shape': {}(3, 5)", "{".repeat(40));
    assert_says(open("a.npy", &npy(&nested, &[0; 120])), &["brackets"]);
    for other in ["'shape'", "'sh\\x61pe'"] {
        let shape = "'shape': (3, 5)";
        let header = format!(
            "{{'descr': '<f8', 'fortran_order': True, {shape}, {other}: (4294967296, 4294967296)}}"
        );
        assert_says(open("a.npy", &npy(&header, &[0; 120])), &["`shape`"]);
    }
}
