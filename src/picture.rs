//! BRDF maps as files: PNG to look at, EXR to compute with.

use std::io::Cursor;

use image::{ImageFormat, Rgba, RgbaImage};

use crate::error::{Error, Result, Stage};
use crate::frame::Frame;
use crate::plan::Colour;
use crate::spectrum::{srgb_encode, to_rgb};

/// An 8-bit PNG: linear RGB times `exposure`, clamped per channel, sRGB curve; transparent outside the disc.
pub fn png(frame: &Frame, colour: Colour, exposure: f64) -> Result<Vec<u8>> {
    let side = frame.size as u32;
    let picture = RgbaImage::from_fn(side, side, |x, y| {
        match frame.xyz[y as usize * frame.size + x as usize] {
            None => Rgba([0; 4]),
            Some(xyz) => {
                let [r, g, b] =
                    to_rgb(xyz, colour).map(|c| (255.0 * srgb_encode(exposure * c)).round() as u8);
                Rgba([r, g, b, 255])
            }
        }
    });
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).map_err(|e| failed("png").source(e))?;
    Ok(bytes.into_inner())
}

/// A 32-bit float EXR of the linear radiance factor, channels R, G, B, not clamped; 0 outside the disc.
pub fn exr(frame: &Frame, colour: Colour) -> Result<Vec<u8>> {
    use exr::prelude::*;
    let pixel = |at: Vec2<usize>| {
        let [r, g, b] =
            frame.xyz[at.y() * frame.size + at.x()].map_or([0.0; 3], |xyz| to_rgb(xyz, colour));
        (r as f32, g as f32, b as f32)
    };
    let channels = SpecificChannels::rgb(pixel);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_channels((frame.size, frame.size), channels)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| failed("exr").source(e))?;
    Ok(bytes.into_inner())
}

fn failed(format: &str) -> Error {
    Error::new(Stage::Run, format!("{format} picture"), "cannot be encoded")
}
