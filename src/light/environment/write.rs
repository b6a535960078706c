//! Panoramas as files.

use exr::image::FlatSamples;

use super::Panorama;
use crate::encode::{self, Floats, Picture};
use crate::error::Result;
use crate::optics::colour::{srgb_encode, tone_map};

impl Panorama {
    /// A 32-bit float EXR file of the radiance, linear sRGB, channels R, G, B.
    pub fn exr(&self) -> Result<Vec<u8>> {
        let channel = |c: usize| FlatSamples::F32(self.texels.iter().map(|t| t[c]).collect());
        encode::exr(Floats {
            size: [self.width, self.height],
            channels: vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))],
            comment: Some("equirectangular radiance, linear sRGB"),
            colours: true,
        })
    }

    /// The tone-mapped picture of the radiance times `exposure`.
    pub fn preview(&self, exposure: f64) -> Picture {
        let texel = |texel: &[f32; 3]| {
            let [r, g, b] = tone_map(texel.map(|c| exposure * f64::from(c)))
                .map(|c| (255.0 * srgb_encode(c)).round() as u8);
            [r, g, b, 255]
        };
        let texels = self.texels.iter().map(texel).collect();
        Picture { width: self.width as u32, height: self.height as u32, texels }
    }
}
