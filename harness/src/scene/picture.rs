//! Linear pictures as files. The tone map is part of what a picture means, so it is stated here.

use std::io::Cursor;

use diffraction_shaders::error::{Error, Result, Stage};
use diffraction_shaders::spectrum::srgb_encode;

/// From which brightness on the tone map bends.
const KNEE: f64 = 0.6;

/// An 8-bit picture, `[row][column]`: red, green, blue, alpha.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Display {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The texels.
    pub texels: Vec<[u8; 4]>,
}

/// Exposes, tone-maps and encodes linear RGB with coverage over black.
pub fn display(width: u32, height: u32, pixels: &[[f32; 4]], exposure: f64) -> Display {
    let texel = |p: &[f32; 4]| {
        let [r, g, b] = tone_map([p[0], p[1], p[2]].map(|c| exposure * f64::from(c)))
            .map(|c| (255.0 * srgb_encode(c)).round() as u8);
        [r, g, b, 255]
    };
    Display { width, height, texels: pixels.iter().map(texel).collect() }
}

/// Brings linear colours into [0, 1] and keeps their hue: negative components become 0; where the greatest component `m`
/// exceeds 0.6, all are scaled so that it becomes `1 - 0.4·exp(-(m - 0.6)/0.4)`.
pub fn tone_map(rgb: [f64; 3]) -> [f64; 3] {
    let rgb = rgb.map(|c| if c > 0.0 { c } else { 0.0 });
    let most = rgb.iter().copied().fold(0.0, f64::max);
    if most <= KNEE {
        return rgb;
    }
    let room = 1.0 - KNEE;
    let bent = 1.0 - room * (-(most - KNEE) / room).exp();
    rgb.map(|c| (c / most).min(1.0) * bent)
}

/// The mean of `factor × factor` pixels each.
pub fn reduced(width: u32, pixels: &[[f32; 4]], factor: u32) -> Vec<[f32; 4]> {
    let (width, factor) = (width as usize, factor as usize);
    let (columns, rows) = (width / factor, pixels.len() / width / factor);
    let mean = |i: usize| {
        let (x, y) = (factor * (i % columns), factor * (i / columns));
        let block = (0..factor * factor).map(|k| pixels[(y + k / factor) * width + x + k % factor]);
        let sum = block.fold([0.0; 4], |sum: [f32; 4], p| std::array::from_fn(|c| sum[c] + p[c]));
        sum.map(|c| c / (factor * factor) as f32)
    };
    (0..columns * rows).map(mean).collect()
}

/// Pictures of one height side by side, `gap` black columns between.
pub fn strip(pictures: &[Display], gap: u32) -> Display {
    let height = pictures.iter().map(|p| p.height).max().unwrap_or(0);
    let gaps = gap * (pictures.len() as u32).saturating_sub(1);
    let width = pictures.iter().map(|p| p.width).sum::<u32>() + gaps;
    let mut texels = vec![[0, 0, 0, 255]; (width * height) as usize];
    let mut left = 0;
    for picture in pictures {
        for (row, line) in picture.texels.chunks_exact(picture.width as usize).enumerate() {
            let at = row * width as usize + left as usize;
            texels[at..at + line.len()].copy_from_slice(line);
        }
        left += picture.width + gap;
    }
    Display { width, height, texels }
}

/// Pictures of one width one above the other, `gap` black rows between.
pub fn stacked(pictures: &[Display], gap: u32) -> Display {
    let width = pictures.iter().map(|p| p.width).max().unwrap_or(0);
    let between = vec![[0, 0, 0, 255]; (width * gap) as usize];
    let mut texels = Vec::new();
    for picture in pictures {
        if !texels.is_empty() {
            texels.extend(&between);
        }
        for line in picture.texels.chunks_exact(picture.width as usize) {
            texels.extend(line);
            texels.resize(texels.len() + (width - picture.width) as usize, [0, 0, 0, 255]);
        }
    }
    Display { width, height: (texels.len() / width.max(1) as usize) as u32, texels }
}

/// A PNG file; of several pictures of one size an animated one, each shown for `delay_ms`, without end.
pub fn png(frames: &[Display], delay_ms: u16) -> Result<Vec<u8>> {
    let fail = |error: png::EncodingError| {
        Error::new(Stage::Run, "png picture", "cannot be encoded").source(error)
    };
    let first =
        frames.first().ok_or_else(|| Error::new(Stage::Run, "png picture", "has no frame"))?;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, first.width, first.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    if frames.len() > 1 {
        encoder.set_animated(frames.len() as u32, 0).map_err(fail)?;
        encoder.set_frame_delay(delay_ms, 1000).map_err(fail)?;
    }
    let mut writer = encoder.write_header().map_err(fail)?;
    for frame in frames {
        let rgb: Vec<u8> = frame.texels.iter().flat_map(|t| [t[0], t[1], t[2]]).collect();
        writer.write_image_data(&rgb).map_err(fail)?;
    }
    writer.finish().map_err(fail)?;
    Ok(bytes)
}

/// A 32-bit float EXR file of the linear colours and the coverage.
pub fn exr(width: u32, height: u32, pixels: &[[f32; 4]]) -> Result<Vec<u8>> {
    use exr::prelude::*;
    let pixel = |at: Vec2<usize>| {
        let [r, g, b, a] = pixels[at.y() * width as usize + at.x()];
        (r, g, b, a)
    };
    let mut bytes = Cursor::new(Vec::new());
    Image::from_channels((width as usize, height as usize), SpecificChannels::rgba(pixel))
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| {
            diffraction_shaders::error::Error::new(Stage::Run, "exr picture", "cannot be encoded")
                .source(e)
        })?;
    Ok(bytes.into_inner())
}
