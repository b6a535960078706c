//! What pictures state is used: Gwyddion's keys, calibrations of ImageJ and OME, resolutions.

use crate::support::heights::*;
use diffraction_shaders::input::read_heights as read;
use diffraction_shaders::plan::{FileSource, Trust};
use diffraction_shaders::surface::read::Reading;
use tiff::encoder::{Rational, TiffEncoder, colortype};
use tiff::tags::{ResolutionUnit, Tag};

#[track_caller]
fn assert_pitch(reading: &Reading, x: f64, y: f64) {
    let found = (reading.pitch_x_um, reading.pitch_y_um);
    assert!((found.0 / x - 1.0).abs() < 1e-6 && (found.1 / y - 1.0).abs() < 1e-6, "{found:?}");
}

/// Where and how a PNG holds its texts.
#[derive(Clone, Copy, Debug)]
enum Chunk {
    Plain,
    Compressed,
    International,
    AfterPixels,
}

fn png_with(keys: &[(&str, &str)], chunk: Chunk) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, COLUMNS as u32, ROWS as u32);
    encoder.set_color(png::ColorType::Grayscale);
    for (key, value) in keys {
        match chunk {
            Chunk::Plain => encoder.add_text_chunk((*key).into(), (*value).into()).unwrap(),
            Chunk::Compressed => encoder.add_ztxt_chunk((*key).into(), (*value).into()).unwrap(),
            Chunk::International => encoder.add_itxt_chunk((*key).into(), (*value).into()).unwrap(),
            Chunk::AfterPixels => {}
        }
    }
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&greys()).unwrap();
    if let Chunk::AfterPixels = chunk {
        for (key, value) in keys {
            let text = png::text_metadata::TEXtChunk::new(*key, *value);
            writer.write_text_chunk(&text).unwrap();
        }
    }
    writer.finish().unwrap();
    out
}

const KEYS: [(&str, &str); 6] = [
    ("Gwy::XReal", "2.5e-06"),
    ("Gwy::YReal", "7.5e-07"),
    ("Gwy::XYUnit", "m"),
    ("Gwy::ZUnit", "m"),
    ("Gwy::ZMin", "-1e-07"),
    ("Gwy::ZMax", "4.1e-07"),
];

#[test]
fn gwyddions_keys_in_png() {
    let dir = folder();
    for chunk in [Chunk::Plain, Chunk::Compressed, Chunk::International, Chunk::AfterPixels] {
        let path = put(&dir, "a.png", &png_with(&KEYS, chunk));
        let mut reading = read(&bare(&path), "probe").unwrap();
        assert_pitch(&reading, 0.5, 0.25);
        // black is the lowest height
        reading.heights_um.iter_mut().for_each(|h| *h += 0.1);
        assert_upright(&reading, 0.51 / 255.0);
    }
    let path = put(&dir, "a.png", &png_with(&KEYS, Chunk::Plain));
    let high = FileSource { height_um: Some(0.6), ..bare(&path) };
    assert_says(read(&high, "probe"), &["height_um = 0.6", "0.51 µm", "Gwy::ZMin", "trust"]);
    let trusted = read(&FileSource { trust: Trust::Plan, ..high }, "probe").unwrap();
    assert!((trusted.heights_um[1] - trusted.heights_um[0] - 3.0 * 0.6 / 255.0).abs() < 1e-12);
    let wide = FileSource { size_um: Some(25.0), ..bare(&path) };
    assert_says(read(&wide, "probe"), &["size_um = 25", "2.5 × 0.75 µm", "Gwy::XReal"]);
    // nothing is invented for a picture without keys, or with keys in volts
    let path = put(&dir, "b.png", &grey_png());
    assert_says(read(&bare(&path), "probe"), &["height_um", "missing"]);
    let volts: Vec<_> =
        KEYS.iter().map(|&(k, v)| if k == "Gwy::ZUnit" { (k, "V") } else { (k, v) }).collect();
    let path = put(&dir, "c.png", &png_with(&volts, Chunk::Plain));
    assert_says(read(&bare(&path), "probe"), &["height_um", "missing"]);
}

/// A picture in OpenEXR with Gwyddion's attributes.
fn exr_with(z_unit: &str) -> Vec<u8> {
    use exr::prelude::*;
    let values: Vec<f32> = greys().into_iter().map(f32::from).collect();
    let list = [AnyChannel::new("Y", FlatSamples::F32(values))].into_iter().collect();
    let mut layer = Layer::new(
        (COLUMNS, ROWS),
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(list),
    );
    let mut put = |key: &str, value: AttributeValue| {
        layer.attributes.other.insert(Text::new_or_panic(key), value);
    };
    put("Gwy::XReal", AttributeValue::F32(2.5e-6));
    put("gwy::YReal", AttributeValue::F64(7.5e-7));
    put("Gwy::XYUnit", AttributeValue::Text(Text::new_or_panic("m")));
    put("Gwy::ZUnit", AttributeValue::Text(Text::new_or_panic(z_unit)));
    put("Gwy::ZScale", AttributeValue::F32(2e-9));
    let mut out = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut out).unwrap();
    out.into_inner()
}

#[test]
fn gwyddions_attributes_in_exr() {
    let dir = folder();
    let path = put(&dir, "a.exr", &exr_with("m"));
    let reading = read(&bare(&path), "probe").unwrap();
    assert_upright(&reading, 2e-3);
    assert_pitch(&reading, 0.5, 0.25);
    let micro = FileSource { z_unit_um: Some(1.0), ..bare(&path) };
    assert_says(read(&micro, "probe"), &["z_unit_um = 1", "0.002 µm per unit", "Gwy::ZScale"]);
    let path = put(&dir, "b.exr", &exr_with("A"));
    assert_says(read(&bare(&path), "probe"), &["A (Gwy::ZScale", "not a unit of length"]);
}

#[test]
fn a_channel_of_an_exr_is_chosen_by_name() {
    let other: Vec<f32> = greys().into_iter().map(|g| 1.0 - f32::from(g) / 100.0).collect();
    let heights: Vec<f32> = greys().into_iter().map(|g| f32::from(g) / 100.0).collect();
    let dir = folder();
    let bytes = exr(COLUMNS, ROWS, &[("height", heights), ("phase", other)], false);
    let path = put(&dir, "a.exr", &bytes);
    assert_says(
        read(&floats(&path), "probe"),
        &["height and phase differ", "channel = \"height\""],
    );
    let by_name = |name: &str| FileSource { channel: Some(name.into()), ..floats(&path) };
    assert_upright(&read(&by_name("Height"), "probe").unwrap(), 0.01);
    assert_says(read(&by_name("depth"), "probe"), &["depth", "height, phase"]);
}

/// An 8-bit TIFF with a description and a resolution.
fn tiff_with(description: &str, per_unit: Option<(u32, u32)>, unit: ResolutionUnit) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap();
    let mut image = encoder.new_image::<colortype::Gray8>(COLUMNS as u32, ROWS as u32).unwrap();
    if !description.is_empty() {
        image.encoder().write_tag(Tag::ImageDescription, description).unwrap();
    }
    if let Some((n, d)) = per_unit {
        image.resolution(unit, Rational { n, d });
    }
    image.write_data(&greys()).unwrap();
    out.into_inner()
}

#[test]
fn calibrations_of_imagej_and_ome() {
    let ome = |unit: &str| {
        format!(
            "<?xml version=\"1.0\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\"><Image ID=\"Image:0\"><Pixels ID=\"Pixels:0\" SizeX=\"5\" PhysicalSizeX=\"0.5\" PhysicalSizeY=\"0.25\"{unit}/></Image></OME>"
        )
    };
    let nm = " PhysicalSizeXUnit=\"nm\" PhysicalSizeYUnit=\"nm\"";
    let two = Some((2, 1));
    let none = ResolutionUnit::None;
    for (bytes, x, y) in [
        (tiff_with("ImageJ=1.53t\nunit=micron\nmin=0\n", two, none), 0.5, 0.5),
        (tiff_with("ImageJ=1.53t\nunit=\\u00B5m\n", two, none), 0.5, 0.5),
        (tiff_with("ImageJ=1.53t\nunit=nm\n", Some((1, 50)), none), 0.05, 0.05),
        (tiff_with(&ome(""), None, none), 0.5, 0.25),
        (tiff_with(&ome(nm), None, none), 5e-4, 2.5e-4),
        // 20,000 pixels per centimetre are no printer's
        (tiff_with("", Some((20_000, 1)), ResolutionUnit::Centimeter), 0.5, 0.5),
    ] {
        let dir = folder();
        let path = put(&dir, "a.tif", &bytes);
        let source = FileSource { height_um: Some(0.51), ..bare(&path) };
        let reading = read(&source, "probe").unwrap();
        assert_upright(&reading, 0.51 / 255.0);
        assert_pitch(&reading, x, y);
        let other = FileSource { size_um: Some(17.0), ..source };
        assert_says(read(&other, "probe"), &["size_um = 17", "trust"]);
    }
    // printers' resolutions and ImageJ's pixels are no scale
    for bytes in [
        tiff_with("", Some((300, 1)), ResolutionUnit::Inch),
        tiff_with("", Some((72, 1)), ResolutionUnit::Inch),
        tiff_with("ImageJ=1.53t\nunit=pixel\n", two, none),
        tiff_with("ImageJ=1.53t\n", two, none),
        tiff_with("a picture", None, none),
    ] {
        let dir = folder();
        let path = put(&dir, "a.tif", &bytes);
        let source = FileSource { height_um: Some(0.51), ..bare(&path) };
        assert_says(read(&source, "probe"), &["no physical scale"]);
    }
}

#[test]
fn heights_that_imagej_calibrates() {
    let text = "ImageJ=1.53t\nunit=nm\ncf=0\nc0=-10.0\nc1=2.0\nvunit=nm\n";
    let dir = folder();
    let path = put(&dir, "a.tif", &tiff_with(text, Some((1, 50)), ResolutionUnit::None));
    let mut reading = read(&bare(&path), "probe").unwrap();
    reading.heights_um.iter_mut().for_each(|h| *h += 0.01);
    assert_upright(&reading, 0.002);
    let plan = FileSource { height_um: Some(0.7), ..bare(&path) };
    assert_says(read(&plan, "probe"), &["height_um = 0.7", "0.51 µm", "vunit"]);
}

#[test]
fn tiffs_without_readable_heights_are_named() {
    // the directory's entry of a tag gets another value
    let patched = |tag: u16, value: u16| {
        let mut bytes = tiff::<colortype::Gray8>(COLUMNS as u32, ROWS as u32, &greys());
        let directory = u32::from_le_bytes(bytes[4..8].try_into().unwrap()) as usize;
        let entries = bytes[directory + 2..].chunks_exact_mut(12);
        let mut found = entries.filter(|e| u16::from_le_bytes([e[0], e[1]]) == tag);
        found.next().unwrap()[8..10].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    let open = |bytes: &[u8]| {
        let dir = folder();
        read(&integers(&put(&dir, "a.tif", bytes)), "probe")
    };
    assert_upright(&open(&patched(262, 1)).unwrap(), 0.51 / 255.0);
    assert_says(open(&patched(262, 3)), &["palette", "16-bit grey"]);
    assert_says(open(&patched(262, 5)), &["CMYK", "grey"]);
    assert_says(open(&patched(259, 50000)), &["Zstandard", "without compression"]);
    assert_says(open(&patched(259, 7)), &["JPEG", "without compression"]);
    assert_says(open(&patched(259, 999)), &["method 999"]);
    let mut out = std::io::Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap();
    let mut image = encoder.new_image::<colortype::Gray8>(COLUMNS as u32, ROWS as u32).unwrap();
    image.encoder().write_tag(Tag::Unknown(50432), 0x0e03_1301u32).unwrap();
    image.write_data(&greys()).unwrap();
    assert_says(open(&out.into_inner()), &["Park Systems", "cargo xtask import", "a.tif"]);
}

#[test]
fn an_image_of_a_tiff_is_chosen_by_number() {
    let mut out = std::io::Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap();
    let turned: Vec<u8> = greys().into_iter().rev().collect();
    for samples in [turned, greys()] {
        encoder.write_image::<colortype::Gray8>(COLUMNS as u32, ROWS as u32, &samples).unwrap();
    }
    let dir = folder();
    let path = put(&dir, "a.tif", &out.into_inner());
    let by = |channel: Option<&str>| {
        read(&FileSource { channel: channel.map(str::to_owned), ..integers(&path) }, "probe")
    };
    assert_upright(&by(Some("2")).unwrap(), 0.51 / 255.0);
    let first = by(None).unwrap();
    assert!(first.notes.iter().any(|n| n.contains("several images")), "{:?}", first.notes);
    assert_eq!(first.heights_um, by(Some("1")).unwrap().heights_um);
    for wrong in ["3", "0", "height"] {
        assert_says(by(Some(wrong)), &["channel", wrong, "no image"]);
    }
}
