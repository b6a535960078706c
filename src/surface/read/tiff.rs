//! TIFF: the first image of the file, with 8-bit or 16-bit unsigned integers or 32-bit or 64-bit floats.

use std::io::Cursor;

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::{check_length, check_pixels, grey};
use crate::error::{Error, Result};
use crate::surface::raster::{Raster, Samples};

/// Values of tags (TIFF 6.0, section 8): `PhotometricInterpretation` with black as zero, `Orientation` with the first
/// row at the top and the first column at the left, `PlanarConfiguration` of interleaved channels, `Compression` of
/// uncompressed data.
const BLACK_IS_ZERO: u32 = 1;
const TOP_LEFT: u32 = 1;
const INTERLEAVED: u32 = 1;
const UNCOMPRESSED: u32 = 1;

/// Reads a file whose byte-order mark has been seen.
pub(super) fn read(bytes: &[u8], subject: &str) -> Result<Raster> {
    let error = |cause: String| Error::new(subject, cause);
    let broken = |e: TiffError| {
        error("the TIFF cannot be decoded".into())
            .source(e)
            .remedy("the file is truncated, damaged or of a rare kind; export it again")
    };
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(broken)?;
    let (width, height) = decoder.dimensions().map_err(broken)?;
    let (columns, rows) = check_pixels(subject, width.into(), height.into())?;
    let colour = decoder.colortype().map_err(broken)?;
    let (channels, alpha) = match colour {
        ColorType::Gray(_) => (1, false),
        ColorType::GrayA(_) => (2, true),
        ColorType::RGB(_) => (3, false),
        ColorType::RGBA(_) => (4, true),
        other => {
            return Err(error(format!("pixels of type {other:?} are not supported"))
                .remedy("export grey heights"));
        }
    };
    let mut tag = |tag: Tag, default: u32| -> Result<u32> {
        Ok(decoder.find_tag_unsigned::<u32>(tag).map_err(broken)?.unwrap_or(default))
    };
    let compressed = tag(Tag::Compression, UNCOMPRESSED)? != UNCOMPRESSED;
    let orientation = tag(Tag::Orientation, TOP_LEFT)?;
    let planar = tag(Tag::PlanarConfiguration, INTERLEAVED)?;
    let black = tag(Tag::PhotometricInterpretation, BLACK_IS_ZERO)?;
    if orientation != TOP_LEFT {
        return Err(error(format!(
            "the TIFF tag Orientation is {orientation}, so the first row is not at the top left"
        ))
        .remedy("export it upright, with Orientation 1"));
    }
    if planar != INTERLEAVED && channels > 1 {
        return Err(error("the channels are stored in separate planes".into())
            .remedy("export a single grey channel"));
    }
    if black == 0 {
        return Err(error("the TIFF tag PhotometricInterpretation is 0, so zero is white and heights would be upside down".into())
            .remedy("export it with zero as black"));
    }
    let total =
        columns as u64 * rows as u64 * channels as u64 * u64::from(colour.bit_depth()).div_ceil(8);
    check_length(subject, bytes.len(), total, compressed)?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = total as usize + 4096;
    limits.intermediate_buffer_size = total as usize + (1 << 20);
    let mut decoder = decoder.with_limits(limits);
    let pixels = decoder.read_image().map_err(broken)?;
    let floats = |values: Vec<f64>| match channels {
        1 => Ok(Samples::float(values)),
        n => Err(error(format!("the float TIFF has {n} channels, but heights need one"))
            .remedy("export one channel")),
    };
    let samples = match pixels {
        DecodingResult::U8(p) if colour.bit_depth() == 8 => {
            grey(&p, channels, alpha, columns, 8, subject)?
        }
        DecodingResult::U16(p) if colour.bit_depth() == 16 => {
            grey(&p, channels, alpha, columns, 16, subject)?
        }
        DecodingResult::F32(p) => floats(p.into_iter().map(f64::from).collect())?,
        DecodingResult::F64(p) => floats(p)?,
        _ => {
            return Err(error(format!(
                "samples of {} bits of this kind are not supported",
                colour.bit_depth()
            ))
            .remedy("export 8-bit or 16-bit unsigned grey, or 32-bit floats"));
        }
    };
    let mut notes = Vec::new();
    if decoder.more_images() {
        notes.push("the TIFF has several images; the first is used".to_owned());
    }
    Ok(Raster { columns, rows, samples, scale: None, notes })
}
