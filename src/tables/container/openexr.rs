//! OpenEXR: the layers of a table side by side, in half or single precision, scan lines without compression.

use std::borrow::Cow;

use exr::image::FlatSamples;
use half::f16;

use crate::encode::{self, Floats};
use crate::error::Result;
use crate::tables::TexelFormat;

use super::{Atlas, Shape};

/// Names of the channels in the order of the table's channels. In a file they are sorted, which is the reverse order.
pub(super) fn channels(format: TexelFormat) -> &'static [&'static str] {
    match format.channels() {
        2 => &["R", "G"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    }
}

/// Index of a table's channel among the channels of a file, `G R` or `A B G R`.
fn place(format: TexelFormat, channel: usize) -> usize {
    format.channels() - 1 - channel
}

pub(super) fn file(shape: &Shape, texels: &[u8]) -> Result<Vec<u8>> {
    let texels = &stored(shape.format, texels);
    let atlas = Atlas::new(shape);
    let comment = format!(
        "{} layers of {} by {} texels, {} in a row, from the upper left",
        atlas.offsets.len(),
        shape.width,
        shape.height,
        atlas.columns
    );
    let names = channels(shape.format).iter().enumerate();
    encode::exr(Floats {
        size: [atlas.width, atlas.height],
        channels: names
            .map(|(channel, name)| (*name, plane(shape, &atlas, texels, channel)))
            .collect(),
        comment: Some(&comment),
        colours: false,
    })
}

/// One channel of the picture. Pixels outside the layers are 0.
fn plane(shape: &Shape, atlas: &Atlas, texels: &[u8], channel: usize) -> FlatSamples {
    let width = number_bytes(shape.format);
    let mut bytes = vec![0; atlas.width * atlas.height * width];
    for_each(shape, atlas, |texel, pixel| {
        let from = (texel * shape.format.channels() + channel) * width;
        bytes[pixel * width..][..width].copy_from_slice(&texels[from..from + width]);
    });
    match width {
        2 => FlatSamples::F16(
            bytes.as_chunks::<2>().0.iter().map(|number| f16::from_le_bytes(*number)).collect(),
        ),
        _ => FlatSamples::F32(
            bytes.as_chunks::<4>().0.iter().map(|number| f32::from_le_bytes(*number)).collect(),
        ),
    }
}

/// The bytes at the position of the texels: the scan lines at the end of the file. Each consists of two 32-bit numbers
/// and the rows of all channels, one after the other.
pub(super) fn texels(shape: &Shape, file: &[u8]) -> Option<Vec<u8>> {
    let (atlas, width) = (Atlas::new(shape), number_bytes(shape.format));
    let channels = shape.format.channels();
    let count = shape.byte_count()? / shape.format.texel_bytes() * channels * width;
    if count > file.len() {
        return None;
    }
    let mut texels = vec![0; count];
    let line = 8 + atlas.width.checked_mul(channels * width)?;
    let lines = file.get(file.len().checked_sub(line.checked_mul(atlas.height)?)?..)?;
    for_each(shape, &atlas, |texel, pixel| {
        let (x, y) = (pixel % atlas.width, pixel / atlas.width);
        for channel in 0..channels {
            let place = place(shape.format, channel);
            let from = y * line + 8 + (place * atlas.width + x) * width;
            let to = (texel * channels + channel) * width;
            texels[to..to + width].copy_from_slice(&lines[from..from + width]);
        }
    });
    Some(match shape.format {
        TexelFormat::Rgb9e5Ufloat => {
            let numbers = texels.as_chunks().0;
            let numbers: Vec<f64> =
                numbers.iter().map(|&pair| f16::from_le_bytes(pair).to_f64()).collect();
            shape.format.encode(&numbers)
        }
        _ => texels,
    })
}

/// Texels as numbers of the file. Numbers with a shared exponent fit into half precision without rounding.
fn stored(format: TexelFormat, texels: &[u8]) -> Cow<'_, [u8]> {
    match format {
        TexelFormat::Rgb9e5Ufloat => {
            let numbers = format.decode(texels);
            numbers.iter().flat_map(|v| f16::from_f64(*v).to_le_bytes()).collect::<Vec<_>>().into()
        }
        _ => texels.into(),
    }
}

/// Bytes of a number in the file.
fn number_bytes(format: TexelFormat) -> usize {
    match format {
        TexelFormat::Rg32Float | TexelFormat::Rgba32Float => 4,
        _ => 2,
    }
}

/// Every texel of a table with its pixel.
fn for_each(shape: &Shape, atlas: &Atlas, mut each: impl FnMut(usize, usize)) {
    let mut texel = 0;
    for [x, y] in &atlas.offsets {
        for row in 0..shape.height {
            for column in 0..shape.width {
                each(texel, (y + row) * atlas.width + x + column);
                texel += 1;
            }
        }
    }
}
