//! Pictures that shape a map.

use std::io::Cursor;

use glam::DVec2;
use image::{ImageFormat, ImageReader, Limits};

use crate::error::{Error, Result};
use crate::pattern::MAX_SIDE;

/// Places along each side over which a mean is taken.
const PLACES: usize = 8;

/// A picture as brightness and opacity, `[row][column]`, from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Stencil {
    width: usize,
    height: usize,
    /// `0.2126 R + 0.7152 G + 0.0722 B` of the numbers in the file, and alpha.
    pixels: Vec<[f32; 2]>,
}

impl Stencil {
    /// Decodes a PNG file of any kind. With `invert`, dark counts as bright. `subject` names the file in errors.
    pub fn decode(bytes: &[u8], invert: bool, subject: &str) -> Result<Stencil> {
        let mut limits = Limits::default();
        (limits.max_image_width, limits.max_image_height) =
            (Some(MAX_SIDE as u32), Some(MAX_SIDE as u32));
        let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
        reader.limits(limits);
        let picture = reader.decode().map_err(|e| {
            let remedy = format!("give a PNG file with at most {MAX_SIDE} pixels on a side");
            Error::new(subject, "cannot be decoded as PNG").source(e).remedy(remedy)
        })?;
        let picture = picture.to_rgba32f();
        let pixel = |pixel: &image::Rgba<f32>| {
            let [r, g, b, alpha] = pixel.0;
            let bright = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            [if invert { 1.0 - bright } else { bright }, alpha]
        };
        let [width, height] = [picture.width(), picture.height()].map(|side| side as usize);
        Ok(Stencil { width, height, pixels: picture.pixels().map(pixel).collect() })
    }

    /// From a place in a map to one in this picture, which is centred and as large as fits.
    pub(super) fn fit(&self, map: [usize; 2]) -> impl Fn(DVec2) -> DVec2 + use<> {
        let map = DVec2::from(map.map(|side| side as f64));
        let own = DVec2::new(self.width as f64, self.height as f64);
        let scale = (own / map).max_element();
        move |at| (at - 0.5 * map) * scale + 0.5 * own
    }

    /// Brightness times opacity: bilinear between the centres of pixels, 0 outside.
    pub(super) fn value(&self, at: DVec2) -> f64 {
        let at = at - 0.5;
        let corner = at.floor();
        let part = at - corner;
        let pixel = |x: f64, y: f64| {
            let [bright, alpha] = self.pixel(corner + DVec2::new(x, y));
            bright * alpha
        };
        let row = |y: f64| pixel(0.0, y) * (1.0 - part.x) + pixel(1.0, y) * part.x;
        row(0.0) * (1.0 - part.y) + row(1.0) * part.y
    }

    /// Mean brightness, weighted with the opacity, and mean opacity between two corners.
    pub(super) fn mean(&self, from: DVec2, to: DVec2) -> [f64; 2] {
        let part = |i: usize| (i as f64 + 0.5) / PLACES as f64;
        let (mut bright, mut opaque) = (0.0, 0.0);
        for i in 0..PLACES * PLACES {
            let share = DVec2::new(part(i % PLACES), part(i / PLACES));
            let [one, alpha] = self.pixel((from + (to - from) * share).floor());
            bright += one * alpha;
            opaque += alpha;
        }
        let mean = if opaque > 0.0 { bright / opaque } else { 0.0 };
        [mean, opaque / (PLACES * PLACES) as f64]
    }

    /// Share of pixels between outside and inside.
    pub fn soft_share(&self) -> f64 {
        let is_soft = |[bright, alpha]: &&[f32; 2]| (0.02..0.98).contains(&(bright * alpha));
        self.pixels.iter().filter(is_soft).count() as f64 / self.pixels.len() as f64
    }

    /// Share of pixels inside, where brightness times opacity is at least 0.5.
    pub fn inside_share(&self) -> f64 {
        let is_inside = |[bright, alpha]: &&[f32; 2]| bright * alpha >= 0.5;
        self.pixels.iter().filter(is_inside).count() as f64 / self.pixels.len() as f64
    }

    fn pixel(&self, at: DVec2) -> [f64; 2] {
        let inside =
            at.min_element() >= 0.0 && at.x < self.width as f64 && at.y < self.height as f64;
        let index = || at.y as usize * self.width + at.x as usize;
        if inside { self.pixels[index()].map(f64::from) } else { [0.0; 2] }
    }
}
