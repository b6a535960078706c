//! TIFF: one image of the file, with 8-bit or 16-bit unsigned integers or 32-bit or 64-bit floats, and the scale that
//! its tags state.

mod kind;
mod said;

use std::io::Cursor;

use tiff::decoder::ifd::Value;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::{check_length, check_pixels, grey};
use crate::error::{Error, Result};
use crate::plan::FileSource;
use crate::surface::raster::{Raster, Samples, Stated};

/// Values of tags (TIFF 6.0, section 8): `PhotometricInterpretation` with black as zero, `Orientation` with the first
/// row at the top and the first column at the left, `PlanarConfiguration` of interleaved channels, `Compression` of
/// uncompressed data, `ResolutionUnit` of inches.
const BLACK_IS_ZERO: u32 = 1;
const TOP_LEFT: u32 = 1;
const INTERLEAVED: u32 = 1;
const UNCOMPRESSED: u32 = 1;
const INCH: u32 = 2;

/// A private tag of Park Systems' files: the mark of their kind.
const PARK: u16 = 50432;

/// Reads a file whose byte-order mark has been seen. The key `channel` is the number of an image.
pub(super) fn read(bytes: &[u8], source: &FileSource, subject: &str) -> Result<Raster> {
    let error = |cause: String| Error::new(subject, cause);
    let broken = |e: TiffError| {
        error("the TIFF cannot be decoded".into())
            .source(e)
            .remedy("the file is truncated, damaged or of a rare kind; export it again")
    };
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(broken)?;
    let mut notes = Vec::new();
    select(&mut decoder, source, subject, &mut notes)?;
    let mut tag = |tag: Tag, default: u32| -> Result<u32> {
        Ok(decoder.find_tag_unsigned::<u32>(tag).map_err(broken)?.unwrap_or(default))
    };
    let compression = tag(Tag::Compression, UNCOMPRESSED)?;
    let colours = tag(Tag::PhotometricInterpretation, BLACK_IS_ZERO)?;
    let orientation = tag(Tag::Orientation, TOP_LEFT)?;
    let planar = tag(Tag::PlanarConfiguration, INTERLEAVED)?;
    let is_park = decoder.find_tag(Tag::Unknown(PARK)).map_err(broken)?.is_some();
    let kind = kind::Tags { compression, colours, is_park };
    kind::check(&kind, subject, &super::import(&source.path))?;
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
    if colours == 0 {
        return Err(error("the TIFF tag PhotometricInterpretation is 0, so zero is white and heights would be upside down".into())
            .remedy("export it with zero as black"));
    }
    let total =
        columns as u64 * rows as u64 * channels as u64 * u64::from(colour.bit_depth()).div_ceil(8);
    check_length(subject, bytes.len(), total, compression != UNCOMPRESSED)?;
    let stated = stated(&mut decoder, colour.bit_depth());
    let mut limits = Limits::default();
    limits.decoding_buffer_size = total as usize + 4096;
    limits.intermediate_buffer_size = total as usize + (1 << 20);
    let mut decoder = decoder.with_limits(limits);
    let pixels = decoder.read_image().map_err(broken)?;
    let floats = |values: Vec<f64>| match channels {
        1 => Ok(Samples::Float(values)),
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
    Ok(Raster { columns, rows, samples, stated, notes })
}

/// Moves to the image that the plan names, or stays at the first.
fn select(
    decoder: &mut Decoder<Cursor<&[u8]>>,
    source: &FileSource,
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<()> {
    let Some(channel) = &source.channel else {
        if decoder.more_images() {
            notes.push(
                "the TIFF has several images; the first is used (`channel = 2` is the second)"
                    .to_owned(),
            );
        }
        return Ok(());
    };
    let number = channel.trim().parse::<usize>().ok().filter(|n| (1..=10_000).contains(n));
    let found = number.is_some_and(|n| decoder.seek_to_image(n - 1).is_ok());
    if found {
        return Ok(());
    }
    Err(Error::new(subject, format!("`channel = {channel}` is no image of the TIFF"))
        .remedy("give the number of an image, from 1"))
}

fn stated(decoder: &mut Decoder<Cursor<&[u8]>>, bits: u8) -> Stated {
    let mut find = |tag: Tag| decoder.find_tag(tag).ok().flatten();
    let ratio = |value: Value| match value {
        Value::Rational(n, d) if d != 0 => Some(f64::from(n) / f64::from(d)),
        _ => None,
    };
    let resolution = [Tag::XResolution, Tag::YResolution].map(|tag| find(tag).and_then(ratio));
    let resolution_unit = find(Tag::ResolutionUnit).and_then(|v| v.into_u32().ok()).unwrap_or(INCH);
    let description = match find(Tag::ImageDescription) {
        Some(Value::Ascii(text)) => text,
        // texts that are not ASCII
        Some(Value::List(bytes)) => {
            let bytes: Vec<u8> = bytes.into_iter().filter_map(|b| b.into_u8().ok()).collect();
            String::from_utf8_lossy(&bytes).into_owned()
        }
        _ => String::new(),
    };
    let top = if bits >= 32 { 1.0 } else { f64::from((1u32 << bits) - 1) };
    said::stated(&said::Tags { description, resolution, resolution_unit, top })
}
