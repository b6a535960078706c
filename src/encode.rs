//! Pictures, float images and JSON as bytes: the only PNG writer, the only OpenEXR writer and the only JSON writer of the
//! library. None of them writes a number that is not finite.

mod json;
mod viridis;

use std::io::Cursor;

use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::math::Vec2;
use exr::meta::attribute::Text;
use exr::meta::header::LayerAttributes;
use exr::prelude::{SmallVec, WritableImage};
use png::{BitDepth, ColorType, Compression, Encoder, EncodingError};

use crate::error::{Error, Result};

pub use json::{json, json_line};
pub use viridis::viridis;

/// An 8-bit picture, `[row][column]`, rows from the top, sRGB.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue, alpha.
    pub texels: Vec<[u8; 4]>,
}

/// A PNG file of a picture. It has an alpha channel only if a texel is transparent.
pub fn png(picture: &Picture) -> Result<Vec<u8>> {
    animation(std::slice::from_ref(picture), 0)
}

/// An animated PNG file of pictures of the same size, each shown for `delay_ms`, in an endless loop.
pub fn animation(frames: &[Picture], delay_ms: u16) -> Result<Vec<u8>> {
    let fail = |error: EncodingError| failed("PNG").source(error);
    let first = frames.first().ok_or_else(|| {
        Error::new("PNG picture", "has no frames").remedy("pass at least one picture")
    })?;
    let opaque = frames.iter().flat_map(|frame| &frame.texels).all(|texel| texel[3] == 255);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, first.width, first.height);
    encoder.set_color(if opaque { ColorType::Rgb } else { ColorType::Rgba });
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::High);
    if frames.len() > 1 {
        encoder.set_animated(frames.len() as u32, 0).map_err(fail)?;
        encoder.set_frame_delay(delay_ms, 1000).map_err(fail)?;
    }
    let mut writer = encoder.write_header().map_err(fail)?;
    for frame in frames {
        let kept = if opaque { 3 } else { 4 };
        let data: Vec<u8> = frame.texels.iter().flat_map(|texel| &texel[..kept]).copied().collect();
        writer.write_image_data(&data).map_err(fail)?;
    }
    writer.finish().map_err(fail)?;
    Ok(bytes)
}

/// A PNG file of numbers that are not colours: four channels of 8 or 16 bits, `[row][column]`, rows from the top, and texts by their keys.
pub fn png_of_numbers(
    [width, height]: [u32; 2],
    samples: &[[u16; 4]],
    wide: bool,
    texts: &[(&str, String)],
) -> Result<Vec<u8>> {
    let fail = |error: EncodingError| failed("PNG").source(error);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(if wide { BitDepth::Sixteen } else { BitDepth::Eight });
    for (key, text) in texts {
        encoder.add_text_chunk((*key).to_owned(), text.clone()).map_err(fail)?;
    }
    let mut writer = encoder.write_header().map_err(fail)?;
    let numbers = samples.iter().flatten();
    let data: Vec<u8> = match wide {
        true => numbers.flat_map(|number| number.to_be_bytes()).collect(),
        false => numbers.map(|number| *number as u8).collect(),
    };
    writer.write_image_data(&data).map_err(fail)?;
    writer.finish().map_err(fail)?;
    Ok(bytes)
}

/// A float image.
pub struct Floats<'a> {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Name and samples of each channel, `[row][column]`, rows from the top.
    pub channels: Vec<(&'static str, FlatSamples)>,
    /// Comment for people who open the file.
    pub comment: Option<&'a str>,
    /// Whether channels hold colours. If not, they hold other numbers and the file is not compressed.
    pub colours: bool,
}

/// An OpenEXR file with one layer, stored as scan lines.
pub fn exr(image: Floats<'_>) -> Result<Vec<u8>> {
    let [width, height] = image.size;
    if i32::try_from(width.max(height)).is_err() {
        let cause =
            format!("{width} × {height} pixels, above the format's limit of {} per side", i32::MAX);
        return Err(Error::new("EXR file", cause).remedy("write a smaller image"));
    }
    // tables hold any bits; their numbers were checked when they were computed
    for (name, samples) in image.channels.iter().filter(|_| image.colours) {
        let number = |i: usize| samples.value_by_flat_index(i).to_f32();
        if let Some(at) = (0..width * height).find(|&i| !number(i).is_finite()) {
            let (column, row, value) = (at % width, at / width, number(at));
            let cause = format!(
                "channel {name} at column {column}, row {row} is {value}, not a finite number"
            );
            return Err(Error::new("EXR file", cause));
        }
    }
    let channel = |(name, sample_data)| AnyChannel {
        name: Text::from(name),
        sample_data,
        quantize_linearly: !image.colours,
        sampling: Vec2(1, 1),
    };
    let channels: SmallVec<[_; 4]> = image.channels.into_iter().map(channel).collect();
    let attributes = LayerAttributes {
        comments: image.comment.and_then(Text::new_or_none),
        software_name: Text::new_or_none("diffraction-shaders"),
        ..LayerAttributes::default()
    };
    let encoding = if image.colours { Encoding::FAST_LOSSLESS } else { Encoding::UNCOMPRESSED };
    let layer = Layer::new(Vec2(width, height), attributes, encoding, AnyChannels::sort(channels));
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut file)
        .map_err(|error| failed("EXR").source(error))?;
    Ok(file.into_inner())
}

fn failed(format: &str) -> Error {
    Error::new(format!("{format} file"), "cannot be encoded")
}
