//! The colour picture of a body.

use std::io::Cursor;

use diffraction_shaders::error::{Error, Result};

/// Maximum width and height of a picture that is read.
const MAX_SIDE: u32 = 8192;
/// Maximum bytes that decoding takes: such a picture in 16 bits for each of four channels.
const MAX_DECODED: u64 = 512 << 20;

/// An sRGB picture, `[row][column]`. The first row is at texture coordinate 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColourMap {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue and alpha; alpha is 255.
    pub texels: Vec<[u8; 4]>,
}

impl ColourMap {
    /// One colour everywhere.
    pub fn plain(colour: [u8; 3]) -> ColourMap {
        let [r, g, b] = colour;
        ColourMap { width: 1, height: 1, texels: vec![[r, g, b, 255]] }
    }

    /// Reads the bytes of a PNG or JPEG file. `subject` names the file in errors.
    pub(crate) fn decode(subject: &str, bytes: &[u8]) -> Result<ColourMap> {
        let unreadable = |error: image::ImageError| {
            Error::new(subject, "cannot be read as a PNG or JPEG picture")
                .source(error)
                .remedy(format!("convert it; it may have at most {MAX_SIDE} × {MAX_SIDE} pixels"))
        };
        let reader = || {
            let mut reader = image::ImageReader::new(Cursor::new(bytes));
            let mut limits = image::Limits::default();
            limits.max_image_width = Some(MAX_SIDE);
            limits.max_image_height = Some(MAX_SIDE);
            limits.max_alloc = Some(MAX_DECODED);
            reader.limits(limits);
            reader.with_guessed_format().map_err(image::ImageError::IoError)
        };
        let picture = reader().and_then(image::ImageReader::decode).map_err(unreadable)?;
        let picture = picture.into_rgb8();
        let texels = picture.pixels().map(|p| [p[0], p[1], p[2], 255]).collect();
        Ok(ColourMap { width: picture.width(), height: picture.height(), texels })
    }

    /// The mipmap levels: the picture, halved down to one texel, averaged in linear light.
    pub fn levels(&self) -> Vec<ColourMap> {
        let mut levels = vec![self.clone()];
        while let Some(last) = levels.last().filter(|l| l.width > 1 || l.height > 1) {
            let next = half(last);
            levels.push(next);
        }
        levels
    }
}

fn half(from: &ColourMap) -> ColourMap {
    let (width, height) = ((from.width / 2).max(1), (from.height / 2).max(1));
    let linear: Vec<f32> = (0..=255).map(|code| decode(f32::from(code as u8) / 255.0)).collect();
    let at = |x: u32, y: u32| {
        from.texels[(y.min(from.height - 1) * from.width + x.min(from.width - 1)) as usize]
    };
    let texel = |i: u32| {
        let (x, y) = (2 * (i % width), 2 * (i / width));
        let four = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
        let mean = |c: usize| four.iter().map(|t| linear[usize::from(t[c])]).sum::<f32>() / 4.0;
        let code = |c| {
            (255.0 * diffraction_shaders::optics::colour::srgb_encode(f64::from(mean(c)))).round()
                as u8
        };
        [code(0), code(1), code(2), 255]
    };
    ColourMap { width, height, texels: (0..width * height).map(texel).collect() }
}

/// The inverse sRGB transfer function (IEC 61966-2-1).
fn decode(code: f32) -> f32 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}
