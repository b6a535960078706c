//! PNG with 8 or 16 bits, with the scale that its text chunks state. Fewer bits and palettes are expanded to 8 bits.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, Limits, Transformations};

use super::{check_length, check_pixels, grey, gwyddion};
use crate::error::{Error, Result};
use crate::surface::raster::{Raster, Stated};

/// Reads a file whose signature has been seen.
pub(super) fn read(bytes: &[u8], subject: &str) -> Result<Raster> {
    let error = |e: png::DecodingError| {
        Error::new(subject, "the PNG cannot be decoded")
            .source(e)
            .remedy("the file is truncated or damaged; export it again")
    };
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: 64 << 20 });
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(error)?;
    let (columns, rows) =
        check_pixels(subject, reader.info().width.into(), reader.info().height.into())?;
    let (colour, depth) = reader.output_color_type();
    let channels = colour.samples();
    let sample = if depth == BitDepth::Sixteen { 2 } else { 1 };
    let total = columns * rows * channels * sample;
    // samples of fewer than eight bits are expanded to bytes
    check_length(subject, bytes.len(), total as u64 / 8, true)?;
    let mut pixels = vec![0; total];
    reader.next_frame(&mut pixels).map_err(error)?;
    // text may follow the pixels; a cut tail loses no heights
    let _ = reader.finish();
    let alpha = matches!(colour, ColorType::GrayscaleAlpha | ColorType::Rgba);
    let samples = if depth == BitDepth::Sixteen {
        let wide: Vec<u16> =
            pixels.as_chunks::<2>().0.iter().map(|&b| u16::from_be_bytes(b)).collect();
        grey(&wide, channels, alpha, columns, 16, subject)?
    } else {
        grey(&pixels, channels, alpha, columns, 8, subject)?
    };
    let stated = stated(reader.info(), [columns, rows]);
    Ok(Raster { columns, rows, samples, stated, notes: Vec::new() })
}

/// What the text chunks state, in all their kinds.
fn stated(info: &png::Info, pixels: [usize; 2]) -> Stated {
    let mut entries: Vec<(String, String)> = Vec::new();
    for chunk in &info.uncompressed_latin1_text {
        entries.push((chunk.keyword.clone(), chunk.text.clone()));
    }
    for chunk in &info.compressed_latin1_text {
        entries.push((chunk.keyword.clone(), chunk.get_text().unwrap_or_default()));
    }
    for chunk in &info.utf8_text {
        entries.push((chunk.keyword.clone(), chunk.get_text().unwrap_or_default()));
    }
    gwyddion::stated(&entries, pixels)
}
