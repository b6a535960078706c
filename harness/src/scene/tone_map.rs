//! Writes linear pictures to files. The tone map is part of a picture's meaning, so it is stated here.

use diffraction_shaders::encode::{self, Floats, Picture};
use diffraction_shaders::error::Result;
use diffraction_shaders::optics::colour::{srgb_encode, tone_map};
use exr::image::FlatSamples;

/// Exposes, tone-maps and encodes linear RGB with coverage over black.
pub fn display(width: u32, height: u32, pixels: &[[f32; 4]], exposure: f64) -> Picture {
    let texel = |p: &[f32; 4]| {
        let [r, g, b] = tone_map([p[0], p[1], p[2]].map(|c| exposure * f64::from(c)))
            .map(|c| (255.0 * srgb_encode(c)).round() as u8);
        [r, g, b, 255]
    };
    Picture { width, height, texels: pixels.iter().map(texel).collect() }
}

/// Reduces a picture: each pixel is the mean of `factor × factor` pixels.
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

/// Pictures of the same height side by side, with `gap` black columns between them.
pub fn strip(pictures: &[Picture], gap: u32) -> Picture {
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
    Picture { width, height, texels }
}

/// Pictures of the same width one above the other, with `gap` black rows between them.
pub fn stacked(pictures: &[Picture], gap: u32) -> Picture {
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
    Picture { width, height: (texels.len() / width.max(1) as usize) as u32, texels }
}

/// A 32-bit float EXR file of linear colours and coverage.
pub fn exr(width: u32, height: u32, pixels: &[[f32; 4]]) -> Result<Vec<u8>> {
    let channel = |c: usize| FlatSamples::F32(pixels.iter().map(|p| p[c]).collect());
    encode::exr(Floats {
        size: [width as usize, height as usize],
        channels: vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2)), ("A", channel(3))],
        comment: None,
        colours: true,
    })
}
