//! PNG with 8 or 16 bits. Fewer bits and palettes are expanded to 8 bits.

use std::io::Cursor;

use image::codecs::png::PngDecoder;
use image::{ColorType, ImageDecoder, Limits};

use super::{check_length, check_pixels, grey};
use crate::error::{Error, Result};
use crate::surface::raster::Raster;

/// Reads a file whose signature has been seen.
pub(super) fn read(bytes: &[u8], subject: &str) -> Result<Raster> {
    let error = |e: image::ImageError| {
        Error::new(subject, "the PNG cannot be decoded")
            .source(e)
            .remedy("the file is truncated or damaged; export it again")
    };
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), Limits::default()).map_err(error)?;
    let (width, height) = decoder.dimensions();
    let (columns, rows) = check_pixels(subject, width.into(), height.into())?;
    let colour = decoder.color_type();
    let total = decoder.total_bytes();
    // samples of fewer than eight bits are expanded to bytes
    check_length(subject, bytes.len(), total / 8, true)?;
    let (channels, alpha) = (usize::from(colour.channel_count()), colour.has_alpha());
    let mut pixels = vec![0; total as usize];
    decoder.read_image(&mut pixels).map_err(error)?;
    let samples = match colour {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            grey(&pixels, channels, alpha, columns, 8, subject)?
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let wide: Vec<u16> =
                pixels.as_chunks::<2>().0.iter().map(|&b| u16::from_ne_bytes(b)).collect();
            grey(&wide, channels, alpha, columns, 16, subject)?
        }
        other => {
            return Err(Error::new(subject, format!("pixels of type {other:?} are not supported"))
                .remedy("export 8-bit or 16-bit grey"));
        }
    };
    Ok(Raster { columns, rows, samples, scale: None, notes: Vec::new() })
}
