//! BRDF maps: the square picture of all viewing directions under one light.
//!
//! Pixel centres are `(x, y) ∈ [-1, 1]²`, `+y` up; `sin θr = |(x, y)|`, `φr = atan2(y, x)`; pixels outside the unit
//! disc are empty.

use exr::image::FlatSamples;
use glam::DVec3;

use crate::encode::{self, Floats, Picture};
use crate::error::{Error, Result};
use crate::optics::colour::{srgb_encode, to_rgb};
use crate::plan::Colour;

/// A picture of `size × size` pixels, top row first. Pixels outside the disc are `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct BrdfMap {
    /// Pixels along a side.
    pub size: usize,
    /// Tristimulus values, `[row][column]`.
    pub xyz: Vec<Option<[f64; 3]>>,
}

/// Direction to the viewer of a pixel of a BRDF map, column from the left and row from the top; `None` outside the disc.
pub fn view_direction(column: usize, row: usize, size: usize) -> Option<DVec3> {
    let place = |index: usize| (2 * index + 1) as f64 / size as f64 - 1.0;
    let (x, y) = (place(column), -place(row));
    let squared = x * x + y * y;
    (squared < 1.0).then(|| DVec3::new(x, y, (1.0 - squared).sqrt()))
}

/// The directions of all pixels inside the disc, row by row.
pub fn view_directions(size: usize) -> Vec<DVec3> {
    (0..size * size).filter_map(|i| view_direction(i % size, i / size, size)).collect()
}

impl BrdfMap {
    /// Places the colours of [`view_directions`] on the square.
    pub fn from_disc(size: usize, colours: &[[f64; 3]]) -> BrdfMap {
        let mut colours = colours.iter();
        let pixel =
            |i| view_direction(i % size, i / size, size).and_then(|_| colours.next().copied());
        BrdfMap { size, xyz: (0..size * size).map(pixel).collect() }
    }

    /// The colours inside the disc, row by row.
    pub fn disc(&self) -> Vec<[f64; 3]> {
        self.xyz.iter().flatten().copied().collect()
    }

    /// A PNG file: linear RGB times `exposure`, clamped per channel, sRGB curve; transparent outside the disc.
    pub fn png(&self, colour: Colour, exposure: f64) -> Result<Vec<u8>> {
        let texel = |xyz: &Option<[f64; 3]>| match xyz {
            None => [0; 4],
            Some(xyz) => {
                let [r, g, b] =
                    to_rgb(*xyz, colour).map(|c| (255.0 * srgb_encode(exposure * c)).round() as u8);
                [r, g, b, 255]
            }
        };
        let is_finite = |xyz: &Option<[f64; 3]>| xyz.iter().flatten().all(|part| part.is_finite());
        if let Some(at) = self.xyz.iter().position(|xyz| !is_finite(xyz)) {
            let (column, row) = (at % self.size, at / self.size);
            let cause = format!(
                "the colour at column {column}, row {row} is {:?}, not finite",
                self.xyz[at]
            );
            return Err(Error::new("PNG picture", cause));
        }
        let side = self.size as u32;
        let texels = self.xyz.iter().map(texel).collect();
        encode::png(&Picture { width: side, height: side, texels })
    }

    /// A 32-bit float EXR file of the linear radiance factor, channels R, G, B, not clamped; 0 outside the disc.
    pub fn exr(&self, colour: Colour) -> Result<Vec<u8>> {
        let rgb = self.xyz.iter().map(|xyz| xyz.map_or([0.0; 3], |xyz| to_rgb(xyz, colour)));
        let rgb: Vec<[f64; 3]> = rgb.collect();
        let channel = |c: usize| FlatSamples::F32(rgb.iter().map(|rgb| rgb[c] as f32).collect());
        encode::exr(Floats {
            size: [self.size; 2],
            channels: vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))],
            comment: None,
            colours: true,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_is_plus_y_and_the_corners_are_outside() {
        let d = view_direction(4, 0, 8).expect("inside");
        assert!(d.y > 0.8 && d.x > 0.0 && (d.length() - 1.0).abs() < 1e-15, "{d}");
        assert_eq!(view_direction(0, 0, 8), None);
        let disc = view_directions(8);
        let colours: Vec<[f64; 3]> = disc.iter().map(|d| d.to_array()).collect();
        assert_eq!(BrdfMap::from_disc(8, &colours).disc(), colours);
    }
}
