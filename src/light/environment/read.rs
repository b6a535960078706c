//! Reads panoramas from OpenEXR and Radiance HDR files. The first bytes of a file tell which it is.

use std::io::{Cursor, Read};

use exr::image::FlatSamples;
use exr::image::read::read as reader;
use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers};
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;

use super::Panorama;
use crate::error::{Error, Result};
use crate::surface::read::check_openexr;

/// Maximum number of rows.
const MAX_ROWS: usize = 4096;
/// Maximum radiance of a pixel.
const MAX_RADIANCE: f32 = 1e9;
/// Corners of the primaries of sRGB and its white point (IEC 61966-2-1): x and y of red, green, blue, white.
const SRGB: [f32; 8] = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];
/// Maximum difference of a coordinate that counts as sRGB.
const NEAR: f32 = 2e-3;

const AGAIN: &str = "the file is truncated or damaged; export it again";
const PANORAMA: &str = "give an equirectangular panorama, twice as wide as high";

/// A picture as its file has it.
struct Picture {
    width: usize,
    height: usize,
    texels: Vec<[f32; 3]>,
    notes: Vec<String>,
}

impl Panorama {
    /// Decodes a file. Returns the panorama and what a user should know about it. `subject` names the file in errors.
    ///
    /// What is refused: a picture that is not twice as wide as high, unless it is one pixel; values that are not finite, or above
    /// 1e9; primaries other than those of sRGB. Negative values, which filters of image editors leave, count as 0.
    pub fn decode(bytes: &[u8], subject: &str) -> Result<(Panorama, Vec<String>)> {
        let error = |cause: String| Error::new(subject, cause);
        let picture = match bytes {
            [0x76, 0x2f, 0x31, 0x01, ..] => openexr(bytes, subject)?,
            [b'#', b'?', ..] => radiance(bytes, subject)?,
            _ => {
                return Err(error("is neither an OpenEXR nor a Radiance HDR file".to_owned())
                    .remedy("give a panorama as .exr or .hdr"));
            }
        };
        let Picture { width, height, mut texels, mut notes } = picture;
        let mut negative = 0;
        for (i, texel) in texels.iter_mut().enumerate() {
            let place = || format!("column {}, row {}", i % width, i / width);
            for value in texel {
                if !value.is_finite() {
                    let cause = format!("is {value} at {}", place());
                    return Err(
                        error(cause).remedy("repair the picture: its values must be finite")
                    );
                }
                if *value > MAX_RADIANCE {
                    let cause = format!("is {value:e} at {}, above {MAX_RADIANCE:e}", place());
                    return Err(error(cause).remedy("scale the picture down, and set `scale`"));
                }
                negative += usize::from(*value < 0.0);
                *value = value.max(0.0);
            }
        }
        if negative > 0 {
            notes.push(format!("{subject}: {negative} negative values count as 0"));
        }
        Ok((Panorama { width, height, texels }, notes))
    }
}

/// The first layer of an OpenEXR file, which must have the channels R, G and B.
fn openexr(bytes: &[u8], subject: &str) -> Result<Picture> {
    let error = |cause: String| Error::new(subject, cause);
    let broken = |e: exr::error::Error| {
        error("the OpenEXR file cannot be decoded".to_owned()).source(e).remedy(AGAIN)
    };
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    check_openexr(&meta, bytes, subject)?;
    for header in &meta.headers {
        let (size, display) = (header.layer_size, header.shared_attributes.display_window);
        let position = header.own_attributes.layer_position;
        if size != display.size || position != display.position {
            let cause = "has a data window that is not its display window".to_owned();
            return Err(error(cause).remedy("export the whole panorama"));
        }
        if let Some(c) = header.shared_attributes.chromaticities {
            let corners = [c.red, c.green, c.blue, c.white];
            primaries(&corners.map(|c| [c.x(), c.y()]).concat(), subject)?;
        }
        check_size(size.x(), size.y(), subject)?;
    }
    let image = reader()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    let layer = image.layer_data;
    let (width, height) = (layer.size.x(), layer.size.y());
    let mut texels = vec![[0.0; 3]; width * height];
    for (at, name) in ["R", "G", "B"].into_iter().enumerate() {
        let mut list = layer.channel_data.list.iter();
        let Some(channel) = list.find(|channel| channel.name.eq(name)) else {
            let cause = format!("has no channel {name}");
            return Err(error(cause).remedy("export red, green and blue, as linear sRGB"));
        };
        let values: Vec<f32> = match &channel.sample_data {
            FlatSamples::F16(values) => values.iter().map(|v| v.to_f32()).collect(),
            FlatSamples::F32(values) => values.clone(),
            FlatSamples::U32(_) => {
                let cause = format!("has whole numbers in channel {name}");
                return Err(error(cause).remedy("export half or float values"));
            }
        };
        if values.len() != texels.len() {
            let cause = format!("channel {name} has fewer pixels than the picture");
            return Err(error(cause).remedy("export it at full resolution"));
        }
        texels.iter_mut().zip(values).for_each(|(texel, value)| texel[at] = value);
    }
    let notes = match meta.headers.len() {
        0 | 1 => Vec::new(),
        _ => vec![format!("{subject}: the file has several layers; the first is used")],
    };
    Ok(Picture { width, height, texels, notes })
}

/// A Radiance HDR file. Values are divided by the exposure that its header states (Ward 1991, "Real pixels").
fn radiance(bytes: &[u8], subject: &str) -> Result<Picture> {
    let error = |cause: String| Error::new(subject, cause);
    let broken = |e: image::ImageError| {
        error("the Radiance HDR file cannot be decoded".to_owned()).source(e).remedy(AGAIN)
    };
    // the decoder knows one of the two first lines that are in use
    let line = bytes.iter().position(|byte| *byte == b'\n').unwrap_or(bytes.len());
    let rest = bytes.get(line..).unwrap_or_default();
    let whole = b"#?RADIANCE".chain(rest);
    let decoder = HdrDecoder::new(std::io::BufReader::new(whole)).map_err(broken)?;
    let meta = decoder.metadata();
    let (width, height) = (meta.width as usize, meta.height as usize);
    check_size(width, height, subject)?;
    if meta.color_correction.is_some_and(|factors| factors != (1.0, 1.0, 1.0)) {
        let cause = "states a colour correction (COLORCORR)".to_owned();
        return Err(error(cause).remedy("export it without one"));
    }
    for (_, value) in meta.custom_attributes.iter().filter(|(key, _)| key == "PRIMARIES") {
        let corners: Vec<f32> = value.split_whitespace().filter_map(|n| n.parse().ok()).collect();
        primaries(&corners, subject)?;
    }
    let exposure = meta.exposure.unwrap_or(1.0);
    if !(exposure.is_finite() && exposure > 0.0) {
        return Err(error(format!("states the exposure {exposure}")).remedy(AGAIN));
    }
    let mut raw = vec![0; width * height * size_of::<[f32; 3]>()];
    decoder.read_image(&mut raw).map_err(broken)?;
    let number =
        |bytes: &[u8]| f32::from_ne_bytes(*bytes.first_chunk().unwrap_or(&[0; 4])) / exposure;
    let texel = |bytes: &[u8]| [0, 4, 8].map(|at| number(bytes.get(at..).unwrap_or_default()));
    let texels = raw.chunks_exact(size_of::<[f32; 3]>()).map(texel).collect();
    let notes = match exposure {
        1.0 => Vec::new(),
        _ => vec![format!("{subject}: values are divided by its exposure, {exposure}")],
    };
    Ok(Picture { width, height, texels, notes })
}

/// Refuses a picture that is no panorama, or too large. It is asked before memory is allocated.
fn check_size(width: usize, height: usize, subject: &str) -> Result<()> {
    if height == 0 || width != 2 * height && (width, height) != (1, 1) {
        let cause = format!("has {width} × {height} pixels, so it is no panorama");
        return Err(Error::new(subject, cause).remedy(PANORAMA));
    }
    if height <= MAX_ROWS {
        return Ok(());
    }
    let cause = format!("has {height} rows, above the limit of {MAX_ROWS}");
    Err(Error::new(subject, cause).remedy("halve its size; colours of relief blur finer detail"))
}

/// Checks the primaries and the white point that a file states: x and y of red, green, blue, white.
fn primaries(corners: &[f32], subject: &str) -> Result<()> {
    let near = |(a, b): (&f32, &f32)| (a - b).abs() < NEAR;
    if corners.len() == SRGB.len() && corners.iter().zip(&SRGB).all(near) {
        return Ok(());
    }
    let cause = "states primaries or a white point other than those of sRGB";
    Err(Error::new(subject, cause).remedy("convert it to linear sRGB"))
}
