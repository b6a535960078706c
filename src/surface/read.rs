//! Height fields from the bytes of files: PNG, TIFF, EXR, NPY, GSF and text.
//!
//! **Orientation.** The first row of the file is the top row. Where a file has coordinates, y counts upwards.
//!
//! **What a file says is used**: sizes, units, the heights of black and white, marks of void pixels. The plan fills in
//! what the file leaves out. Where both say something and differ by more than 1 % it is an error, unless `trust = "plan"`.
//!
//! **Heights.** Integer files need `height_um`, the height of the *full* grey range (0…255 or 0…65535), not of the
//! image's own extrema. Numbers of float files are in the file's unit, or `z_unit_um` µm, or µm. NaN marks a void pixel;
//! `void_value` names another mark.
//!
//! **Scale.** `size_um` (the width, or the length of a profile), `size_y_um`, or `pixel_um`. With `size_um` alone pixels
//! have the file's aspect, or are square.
//!
//! The declared size is checked against the limits and the length of the file before memory is allocated.

mod format;
mod gwyddion;
mod heights;
mod magnitude;
mod marks;
mod npy;
mod openexr;
mod png;
mod scale;
mod steps;
mod text;
mod tiff;

use std::path::Path;

use crate::error::{Error, Result, shell_path};
use crate::plan::{FileSource, Flip};
use crate::surface::raster::{Raster, Samples};
use crate::surface::{check_pixels, gsf};
use format::Format;

pub(crate) use openexr::check as check_openexr;

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
    let format = format::of_path(&source.path, subject)?;
    format::check_content(format, bytes, &source.path, subject)?;
    finish(source, subject, decode(format, bytes, source, subject)?)
}

/// Checks the plan's numbers for a file.
pub fn check_source(source: &FileSource, subject: &str) -> Result<()> {
    scale::check_keys(source, subject)?;
    heights::check_keys(source, subject)
}

/// Checks that the extension of a file belongs to a known format.
pub fn check_extension(path: &Path, subject: &str) -> Result<()> {
    format::of_path(path, subject).map(drop)
}

/// The command that converts an instrument's file.
fn import(path: &Path) -> String {
    format!("cargo xtask import {}", shell_path(path))
}

fn decode(format: Format, bytes: &[u8], source: &FileSource, subject: &str) -> Result<Raster> {
    if let (Format::Png | Format::Npy | Format::Gsf, Some(channel)) = (format, &source.channel)
        && channel.trim() != "1"
    {
        let cause = format!("`channel = {channel}`, but the file has one channel without a name");
        return Err(Error::new(subject, cause).remedy("remove `channel`"));
    }
    match format {
        Format::Png => png::read(bytes, subject),
        Format::Tiff => tiff::read(bytes, source, subject),
        Format::Exr => openexr::read(bytes, source, subject),
        Format::Npy => npy::read(bytes, subject),
        Format::Gsf => gsf::read(bytes, subject),
        Format::Text => text::read(bytes, source, subject),
    }
}

/// Applies the plan's keys to the samples.
fn finish(source: &FileSource, subject: &str, raster: Raster) -> Result<Reading> {
    let Raster { columns, rows, mut samples, stated, mut notes } = raster;
    marks::apply(source, &stated, &mut samples, subject, &mut notes)?;
    let conversion = heights::conversion(source, &samples, &stated, subject, &mut notes)?;
    let shape = scale::Shape { columns, rows, stated: &stated, unit_um: conversion.unit_um() };
    let pitch = scale::pitch(source, &shape, subject, &mut notes)?;
    let steps = conversion.steps(&samples);
    notes.extend(steps.as_ref().map(ToString::to_string));
    let is_grey = matches!(samples, Samples::Grey { .. });
    let mut heights_um = conversion.heights(samples, columns, subject)?;
    notes.extend(magnitude::note(&heights_um, columns, pitch, &conversion, is_grey));
    match source.flip {
        Flip::None => {}
        Flip::Rows => {
            let turned = heights_um.chunks_exact(columns).rev().flatten().copied().collect();
            heights_um = turned;
        }
        Flip::Columns => heights_um.chunks_exact_mut(columns).for_each(<[f64]>::reverse),
    }
    Ok(Reading {
        columns,
        rows,
        pitch_x_um: pitch.0,
        pitch_y_um: pitch.1,
        heights_um,
        step_um: steps.map(|steps| steps.size_um),
        notes,
    })
}

/// Subject of errors about a surface with a file.
pub fn subject(name: &str, path: &Path) -> String {
    format!("surface {name}: {}", path.display())
}

/// Checks that a file of `length` bytes can hold `bytes` of pixels, `compressed` or not.
pub(crate) fn check_length(
    subject: &str,
    length: usize,
    bytes: u64,
    compressed: bool,
) -> Result<()> {
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
