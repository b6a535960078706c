//! Height fields from the bytes of files: PNG, TIFF, EXR, NPY, GSF and text matrices.
//!
//! **Orientation.** The first row of the file is the top row, in every format.
//!
//! **Heights.** Integer files need `height_um`, the height of the *full* grey range (0…255 or 0…65535), not of the
//! image's own extrema. Numbers of float files are multiplied by `z_unit_um` to give µm. Its default is the unit of a
//! GSF file, and 1 otherwise. NaN marks a void pixel.
//!
//! **Scale.** A GSF file contains its own. Other files need `size_um` (the width, or the length of a profile) or
//! `pixel_um`, and have square pixels. Resolution tags of pictures are meant for printers and ignored. **A scale in the
//! plan overrides that of a GSF file**, with a note that states both: scanners are sometimes recalibrated later, and
//! the plan is the place to record it. `size_um` keeps the file's aspect ratio of pixels, `pixel_um` makes them square.
//!
//! The declared size is checked against the limits and the length of the file before memory is allocated.

mod npy;
mod openexr;
mod png;
mod text;
mod tiff;
mod units;

use std::path::Path;

use crate::error::{Error, Result};
use crate::plan::FileSource;
use crate::surface::raster::{Raster, Samples};
use crate::surface::{check_pixels, gsf};

/// Maximum size of a file in bytes: [`crate::surface::MAX_PIXELS`] pixels of four 64-bit channels, or of 30 characters
/// each as text.
pub const MAX_FILE_BYTES: u64 = 1 << 31;

/// Maximum number of bytes of pixels per byte of file. No accepted compression reaches it: deflate 1032 (two bits for a
/// match of 258 bytes), LZW about 1340 (a dictionary of 4096 growing runs), EXR's PIZ about 500.
const MAX_COMPRESSION: u64 = 1500;

/// The content of a file in µm, before voids are filled.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Pixels along x.
    pub columns: usize,
    /// Pixels along y.
    pub rows: usize,
    /// Pixel pitch along x, µm.
    pub pitch_x_um: f64,
    /// Pixel pitch along y, µm.
    pub pitch_y_um: f64,
    /// Heights in µm, `[row][column]`, row 0 at the top. NaN for void pixels, otherwise finite.
    pub heights_um: Vec<f64>,
    /// Step between neighbouring heights of an integer file, µm: the largest step of which all differences of samples
    /// are multiples.
    pub step_um: Option<f64>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// Decodes the heights of surface `name` from the bytes of its file. `source.path` determines the format and is not opened.
///
/// The extension determines the format, and the content must match it. Errors name the surface, the file, the key or
/// the place in the file, the value, and what to do.
pub fn parse(source: &FileSource, name: &str, bytes: &[u8]) -> Result<Reading> {
    let subject = &subject(name, &source.path);
    check_source(source, subject)?;
    let format = of_path(&source.path, subject)?;
    check_content(format, bytes, &source.path, subject)?;
    finish(source, subject, decode(format, bytes, subject)?)
}

/// Checks the plan's numbers for a file.
pub fn check_source(source: &FileSource, subject: &str) -> Result<()> {
    units::check_keys(source, subject)
}

/// Checks that the extension of a file belongs to a known format.
pub fn check_extension(path: &Path, subject: &str) -> Result<()> {
    of_path(path, subject).map(drop)
}

fn decode(format: Format, bytes: &[u8], subject: &str) -> Result<Raster> {
    match format {
        Format::Png => png::read(bytes, subject),
        Format::Tiff => tiff::read(bytes, subject),
        Format::Exr => openexr::read(bytes, subject),
        Format::Npy => npy::read(bytes, subject),
        Format::Gsf => gsf::read(bytes, subject),
        Format::Text => text::read(bytes, subject),
    }
}

/// Applies the plan's keys to the samples.
fn finish(source: &FileSource, subject: &str, mut raster: Raster) -> Result<Reading> {
    let mut notes = std::mem::take(&mut raster.notes);
    let (columns, rows) = (raster.columns, raster.rows);
    let (pitch_x_um, pitch_y_um) = units::pitch(source, &raster, subject, &mut notes)?;
    let steps = units::steps(source, &raster.samples);
    let heights_um = units::heights(source, raster.samples, columns, subject, &mut notes)?;
    notes.extend(steps.as_ref().map(ToString::to_string));
    let step_um = steps.map(|steps| steps.size_um);
    Ok(Reading { columns, rows, pitch_x_um, pitch_y_um, heights_um, step_um, notes })
}

/// Subject of errors about a surface with a file.
pub fn subject(name: &str, path: &Path) -> String {
    format!("surface {name}: {}", path.display())
}

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Png,
    Tiff,
    Exr,
    Npy,
    Gsf,
    Text,
}

impl Format {
    fn of_extension(extension: &str) -> Option<Format> {
        Some(match extension.to_ascii_lowercase().as_str() {
            "png" => Format::Png,
            "tif" | "tiff" => Format::Tiff,
            "exr" => Format::Exr,
            "npy" => Format::Npy,
            "gsf" => Format::Gsf,
            "txt" | "csv" => Format::Text,
            _ => return None,
        })
    }

    /// The format by the first bytes. Content without another format's mark and without control characters is text.
    fn of_content(bytes: &[u8]) -> Option<Format> {
        let marks: [(&[u8], Format); 8] = [
            (b"\x89PNG\r\n\x1a\n", Format::Png),
            (b"II*\0", Format::Tiff),
            (b"MM\0*", Format::Tiff),
            (b"II+\0", Format::Tiff),
            (b"MM\0+", Format::Tiff),
            (b"\x76\x2f\x31\x01", Format::Exr),
            (b"\x93NUMPY", Format::Npy),
            (gsf::MAGIC, Format::Gsf),
        ];
        let marked =
            marks.iter().find(|(mark, _)| bytes.starts_with(mark)).map(|&(_, format)| format);
        let head = &bytes[..bytes.len().min(1024)];
        let texty = |b: &u8| *b >= b' ' || b.is_ascii_whitespace();
        marked.or_else(|| head.iter().all(texty).then_some(Format::Text))
    }

    fn name(self) -> &'static str {
        match self {
            Format::Png => "PNG",
            Format::Tiff => "TIFF",
            Format::Exr => "OpenEXR",
            Format::Npy => "NPY",
            Format::Gsf => "Gwyddion Simple Field",
            Format::Text => "text",
        }
    }
}

/// The extension of a path; empty if it has none.
fn extension(path: &Path) -> &str {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default()
}

/// The format that belongs to the extension.
fn of_path(path: &Path, subject: &str) -> Result<Format> {
    let extension = extension(path);
    Format::of_extension(extension).ok_or_else(|| {
        let cause = format!("the extension `{extension}` does not belong to a known format");
        Error::new(subject, cause)
            .remedy("convert the file to one of png, tif, tiff, exr, npy, gsf, txt, csv")
    })
}

/// Checks that the content matches the extension.
fn check_content(format: Format, bytes: &[u8], path: &Path, subject: &str) -> Result<()> {
    let error = |cause: String| Error::new(subject, cause);
    if bytes.is_empty() {
        return Err(error("the file is empty".into()).remedy("export it again"));
    }
    let (extension, name) = (extension(path), format.name());
    match Format::of_content(bytes) {
        Some(found) if found == format => Ok(()),
        Some(found) => {
            let found = found.name();
            Err(error(format!(
                "the content is {found}, although the extension `{extension}` stands for {name}"
            ))
            .remedy("rename or convert the file"))
        }
        None => Err(error(format!(
            "the content is not {name}, although the extension is `{extension}`"
        ))
        .remedy("the file is damaged or has the wrong name; export it again")),
    }
}

/// Checks that a file of `length` bytes can hold `bytes` of pixels, `compressed` or not.
fn check_length(subject: &str, length: usize, bytes: u64, compressed: bool) -> Result<()> {
    let max_bytes = if compressed { length as u64 * MAX_COMPRESSION } else { length as u64 };
    if bytes <= max_bytes {
        return Ok(());
    }
    let cause = format!(
        "the header declares {bytes} bytes of pixels, more than a file of {length} bytes can contain"
    );
    Err(Error::new(subject, cause).remedy("the file is truncated or damaged; export it again"))
}

/// Grey shares from interleaved integer samples, `channels` of them per pixel. If `alpha`, the last is the opacity.
///
/// Red, green and blue must be exactly equal. A fully transparent pixel is void.
fn grey<T: Copy + Into<u32>>(
    samples: &[T],
    channels: usize,
    alpha: bool,
    columns: usize,
    bits: u8,
    subject: &str,
) -> Result<Samples> {
    let top = (1u32 << bits) - 1;
    let place = |i: usize| format!("column {}, row {}", i % columns, i / columns);
    let error = |cause: String| Error::new(subject, cause);
    let mut shares = Vec::with_capacity(samples.len() / channels);
    for (i, pixel) in samples.chunks_exact(channels).enumerate() {
        let value = |c: usize| -> u32 { pixel[c].into() };
        if alpha {
            match value(channels - 1) {
                0 => {
                    shares.push(f64::NAN);
                    continue;
                }
                a if a < top => {
                    return Err(error(format!(
                        "the pixel at {} is partly transparent ({a} of {top})",
                        place(i)
                    ))
                    .remedy("make pixels opaque, or fully transparent where the height is void"));
                }
                _ => {}
            }
        }
        let colours = if alpha { channels - 1 } else { channels };
        if (1..colours).any(|c| value(c) != value(0)) {
            let listed: Vec<String> = (0..colours).map(|c| value(c).to_string()).collect();
            return Err(error(format!(
                "the pixel at {} is coloured ({})",
                place(i),
                listed.join(", ")
            ))
            .remedy("export the heights as a grey image; false colours cannot be converted back"));
        }
        shares.push(f64::from(value(0)) / f64::from(top));
    }
    Ok(Samples::Grey { shares, bits })
}
