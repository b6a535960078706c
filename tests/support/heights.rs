//! Files and plan values for the tests of height fields.

use std::path::{Path, PathBuf};

use diffraction_shaders::error::Error;
use diffraction_shaders::plan::{FileSource, Level, SurfaceOptics, SurfaceSource, SurfaceSpec};
use diffraction_shaders::surface::read::Reading;

pub const COLUMNS: usize = 5;
pub const ROWS: usize = 3;

/// [`greys`] as numbers of a hundredth each, one string per row.
pub fn rows(between: &str) -> Vec<String> {
    let cell = |col, row| format!("{:.2}", f64::from(grey(col, row)) / 100.0);
    (0..ROWS).map(|r| (0..COLUMNS).map(|c| cell(c, r)).collect::<Vec<_>>().join(between)).collect()
}

/// No two equal, no symmetry: the top left corner is 7, columns step by 3, rows by 40.
pub fn grey(col: usize, row: usize) -> u8 {
    (7 + 3 * col + 40 * row) as u8
}

/// [`grey`] as one list, top row first.
pub fn greys() -> Vec<u8> {
    (0..ROWS).flat_map(|r| (0..COLUMNS).map(move |c| grey(c, r))).collect()
}

/// Top left 7, one to the right 10, one row down 47: so neither flipped nor transposed.
#[track_caller]
pub fn assert_upright(reading: &Reading, unit: f64) {
    assert_eq!((reading.columns, reading.rows), (COLUMNS, ROWS));
    for (i, h) in reading.heights_um.iter().enumerate() {
        let wanted = f64::from(grey(i % COLUMNS, i / COLUMNS)) * unit;
        assert!((h - wanted).abs() <= 1e-6 * wanted, "pixel {i}: {h}, not {wanted}");
    }
    assert!(
        (reading.heights_um[0] - 7.0 * unit).abs() < 1e-6
            && (reading.heights_um[5] - 47.0 * unit).abs() < 1e-6
    );
}

/// A folder that vanishes with the test.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

pub fn put(dir: &tempfile::TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = dir.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// A file about which the plan says nothing.
pub fn bare(path: &Path) -> FileSource {
    FileSource { path: path.to_owned(), ..FileSource::default() }
}

/// A file of floats with a pitch of 0.1 µm.
pub fn floats(path: &Path) -> FileSource {
    FileSource { path: path.to_owned(), pixel_um: Some(0.1), ..FileSource::default() }
}

/// A file of integers with a pitch of 0.1 µm and a full range of 0.51 µm.
pub fn integers(path: &Path) -> FileSource {
    FileSource { height_um: Some(0.51), ..floats(path) }
}

pub fn surface(source: FileSource) -> SurfaceSpec {
    SurfaceSpec {
        name: "probe".into(),
        source: SurfaceSource::File(source),
        rotate_deg: 0.0,
        level: Level::None,
        clip_percent: 0.0,
        optics: SurfaceOptics::default(),
    }
}

/// The error's text, after checking that it holds every one of `parts` and reads like an error of ours.
#[track_caller]
pub fn assert_says<T: std::fmt::Debug>(result: Result<T, Error>, parts: &[&str]) {
    let text = result.unwrap_err().to_string();
    for part in parts {
        assert!(text.contains(part), "`{part}` is not in `{text}`");
    }
    assert!(!text.ends_with('.') && !text.contains('\n'), "`{text}`");
}

pub fn png(width: u32, height: u32, colour: image::ExtendedColorType, bytes: &[u8]) -> Vec<u8> {
    use image::ImageEncoder;
    let mut out = Vec::new();
    image::codecs::png::PngEncoder::new(&mut out)
        .write_image(bytes, width, height, colour)
        .unwrap();
    out
}

/// The surface of [`greys`] as an 8-bit PNG.
pub fn grey_png() -> Vec<u8> {
    png(COLUMNS as u32, ROWS as u32, image::ExtendedColorType::L8, &greys())
}

pub fn tiff<C: tiff::encoder::colortype::ColorType>(
    width: u32,
    height: u32,
    samples: &[C::Inner],
) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut out = std::io::Cursor::new(Vec::new());
    tiff::encoder::TiffEncoder::new(&mut out)
        .unwrap()
        .write_image::<C>(width, height, samples)
        .unwrap();
    out.into_inner()
}

/// An NPY file of version 1 with any header dictionary.
pub fn npy(dictionary: &str, data: &[u8]) -> Vec<u8> {
    let mut header = dictionary.to_owned();
    while !(header.len() + 11).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

/// An NPY file of the given element type, order and shape.
pub fn npy_of(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let fortran = if fortran { "True" } else { "False" };
    npy(&format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}"), data)
}

/// A GSF file from header lines and data, padded by the format's rule.
pub fn gsf(header: &str, data: &[f32]) -> Vec<u8> {
    let mut bytes = format!("Gwyddion Simple Field 1.0\n{header}").into_bytes();
    let padding = 4 - bytes.len() % 4;
    bytes.extend(std::iter::repeat_n(0, padding));
    bytes.extend(data.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// An EXR file of named single-precision channels.
pub fn exr(width: usize, height: usize, channels: &[(&str, Vec<f32>)], compress: bool) -> Vec<u8> {
    use exr::prelude::*;
    let list = channels
        .iter()
        .map(|(name, v)| AnyChannel::new(*name, FlatSamples::F32(v.clone())))
        .collect();
    let encoding = if compress { Encoding::SMALL_LOSSLESS } else { Encoding::UNCOMPRESSED };
    let layer =
        Layer::new((width, height), LayerAttributes::default(), encoding, AnyChannels::sort(list));
    let mut out = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut out).unwrap();
    out.into_inner()
}
