//! A picture of a map for people: its numbers as colours, and a sketch of its first order.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};

use super::{PatternMap, Ranges, Texel};
use crate::encode::Picture;
use crate::error::Result;
use crate::optics::colour::{srgb_encode, to_rgb, tone_map};
use crate::optics::spectrum::Spectrum;
use crate::plan::{Colour, Optics};

/// Largest side of one of the two pictures.
const PANEL: usize = 1024;
/// Distance between pictures and to the edge, and the height of the strip below.
const MARGIN: usize = 16;
const STRIP: usize = 112;
/// Radius of the discs in the strip.
const DISC: f64 = 44.0;
const GROUND: DVec3 = DVec3::splat(0.012);
const BARE: DVec3 = DVec3::splat(0.03);
const SOFT: f64 = 0.17;
const WHITE: DVec3 = DVec3::splat(0.8);

/// The light of the sketch: a white lamp, seen along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sketch {
    /// Direction of the lamp from the normal, from 0 to 90.
    pub theta_deg: f64,
    /// Direction of the lamp from the tangent towards the bitangent.
    pub phi_deg: f64,
    /// Period of the compiled profile.
    pub period_um: f64,
}

impl Sketch {
    /// Radiance of the first order, without any unit: 1 is bright. The wavelength is `a·period·sin θ·|cos(φ - φ_light)|`. A Gaussian
    /// of the angle between grating and lamp, with a standard deviation of 10° and that of the texel, stands for lamp, eye and
    /// waviness. Neither the profile nor other orders are in it.
    fn first_order(&self, spectrum: &Spectrum, texel: &Texel) -> DVec3 {
        let off = texel.angle_rad - self.phi_deg.to_radians();
        let path_um = texel.period_ratio * self.period_um * self.theta_deg.to_radians().sin();
        let lambda_nm = 1e3 * path_um * off.cos().abs();
        // what mirrors the grating mirrors its first orders
        let off = off.rem_euclid(PI);
        let off = if off > FRAC_PI_2 { off - PI } else { off };
        let variance = SOFT * SOFT + texel.angle_spread_rad * texel.angle_spread_rad;
        let seen = SOFT / variance.sqrt() * (-0.5 * off * off / variance).exp();
        // the brightest wavelength of an illuminant has about 0.01 of Y per nm
        let rgb = DVec3::from(to_rgb(spectrum.per_nm(lambda_nm), Colour::Srgb));
        // a screen shows no pure wavelength: white is added until it can
        60.0 * texel.mask * seen * (rgb - rgb.min_element().min(0.0))
    }
}

impl PatternMap {
    /// Two pictures side by side, each scaled down to 1024 pixels at most. Left: the direction as hue, the period as lightness; the
    /// disc below has the colours of all directions, with the lowest period in its middle and the highest at its edge. Right: a
    /// sketch of the first order; the dot in the disc below is the lamp, as seen from above.
    pub fn preview(&self, ranges: &Ranges, sketch: &Sketch) -> Result<Picture> {
        let spectrum = Spectrum::new(&Optics::standard().illuminant)?;
        let numbers = |texel: &Texel| BARE.lerp(legend(texel, ranges), texel.mask);
        let order = |texel: &Texel| GROUND + sketch.first_order(&spectrum, texel);
        let block = self.width.max(self.height).div_ceil(PANEL);
        let (width, height) = (self.width.div_ceil(block), self.height.div_ceil(block));
        let size = [3 * MARGIN + 2 * width, 2 * MARGIN + height + STRIP];
        let mut canvas = Canvas { width: size[0], texels: vec![GROUND; size[0] * size[1]] };
        let right = 2 * MARGIN + width;
        for row in 0..height {
            for column in 0..width {
                let [left_colour, right_colour] =
                    self.block(block, row, column, [&numbers, &order]);
                canvas.set(MARGIN + column, MARGIN + row, left_colour);
                canvas.set(right + column, MARGIN + row, right_colour);
            }
        }
        let middle = (MARGIN + height) as f64 + 0.5 * (STRIP + MARGIN) as f64;
        let discs = [MARGIN, right].map(|x| DVec2::new(x as f64 + DISC, middle));
        canvas.disc(discs[0], DISC, |from| {
            let place = Texel {
                angle_rad: from.y.atan2(from.x),
                period_ratio: period_of(from.length(), ranges),
                ..Texel::default()
            };
            Some(legend(&place, ranges))
        });
        let (sin, cos) = sketch.phi_deg.to_radians().sin_cos();
        let lamp = sketch.theta_deg.to_radians().sin() * DVec2::new(cos, sin);
        canvas.disc(discs[1], DISC, |from| {
            let on_lamp = from.distance(0.9 * lamp) < 0.09;
            let on_edge = from.length() > 0.95 || from.length() < 0.04;
            (on_lamp || on_edge).then_some(WHITE)
        });
        Ok(canvas.picture())
    }

    /// Means of two colours over a block of texels.
    fn block(
        &self,
        block: usize,
        row: usize,
        column: usize,
        colours: [&dyn Fn(&Texel) -> DVec3; 2],
    ) -> [DVec3; 2] {
        let rows = row * block..((row + 1) * block).min(self.height);
        let columns = column * block..((column + 1) * block).min(self.width);
        let count = (rows.len() * columns.len()) as f64;
        let mut sums = [DVec3::ZERO; 2];
        for row in rows {
            for texel in &self.texels[row * self.width..][columns.clone()] {
                sums.iter_mut().zip(colours).for_each(|(sum, colour)| *sum += colour(texel));
            }
        }
        sums.map(|sum| sum / count)
    }
}

/// Hue and lightness of a direction and a period, linear sRGB.
fn legend(texel: &Texel, ranges: &Ranges) -> DVec3 {
    let [low, high] = ranges.period_ratio.map(f64::ln);
    let share = if high > low { (texel.period_ratio.ln() - low) / (high - low) } else { 0.5 };
    let part = |third: f64| 0.5 + 0.5 * (texel.angle_rad - third * TAU / 3.0).cos();
    let hue = DVec3::new(part(0.0), part(1.0), part(2.0));
    let light = 0.25 + 0.75 * share.clamp(0.0, 1.0);
    light * hue.lerp(DVec3::ONE, 0.25 * share.clamp(0.0, 1.0))
}

/// The period at a radius of the legend.
fn period_of(radius: f64, ranges: &Ranges) -> f64 {
    let [low, high] = ranges.period_ratio;
    low * (high / low).powf(radius)
}

/// Linear colours.
struct Canvas {
    width: usize,
    texels: Vec<DVec3>,
}

impl Canvas {
    fn set(&mut self, x: usize, y: usize, colour: DVec3) {
        if let Some(texel) = self.texels.get_mut(y * self.width + x).filter(|_| x < self.width) {
            *texel = colour;
        }
    }

    /// Colours a disc, y up; its edge is at the distance 1. Each pixel is the mean over 3 × 3 places.
    fn disc(&mut self, middle: DVec2, radius: f64, colour: impl Fn(DVec2) -> Option<DVec3>) {
        let begin = (middle - radius - 1.0).max(DVec2::ZERO).as_usizevec2();
        let end = (middle + radius + 1.0).as_usizevec2();
        for y in begin.y..=end.y {
            for x in begin.x..=end.x {
                let mut sum = DVec3::ZERO;
                for place in 0..9 {
                    let part = |i: usize| (i as f64 + 0.5) / 3.0;
                    let at = DVec2::new(x as f64 + part(place % 3), y as f64 + part(place / 3));
                    let from = (at - middle) / radius * DVec2::new(1.0, -1.0);
                    let inside = Some(from).filter(|from| from.length() < 1.0);
                    sum += inside.and_then(&colour).unwrap_or(GROUND);
                }
                self.set(x, y, sum / 9.0);
            }
        }
    }

    fn picture(&self) -> Picture {
        let texel = |colour: &DVec3| {
            let [r, g, b] =
                tone_map(colour.to_array()).map(|c| (255.0 * srgb_encode(c)).round() as u8);
            [r, g, b, 255]
        };
        let height = self.texels.len() / self.width;
        let texels = self.texels.iter().map(texel).collect();
        Picture { width: self.width as u32, height: height as u32, texels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::spectrum::{TABLE_MAX_NM, TABLE_MIN_NM};

    /// A grating across the lamp is dark; along it, colours follow the grating equation; mirrored, it is the same.
    #[test]
    fn the_sketch_follows_the_grating_equation() {
        let spectrum = Spectrum::new(&Optics::standard().illuminant).unwrap();
        let sketch = Sketch { theta_deg: 30.0, phi_deg: 40.0, period_um: 1.0 };
        let seen = |angle_deg: f64, period_ratio: f64| {
            let texel =
                Texel { angle_rad: angle_deg.to_radians(), period_ratio, ..Texel::default() };
            sketch.first_order(&spectrum, &texel)
        };
        // 450, 540 and 630 nm
        for (ratio, brightest) in [(0.9, 2), (1.08, 1), (1.26, 0)] {
            let colour = seen(40.0, ratio);
            assert_eq!(colour.max_position(), brightest, "{ratio}: {colour}");
            assert!((seen(220.0, ratio) - colour).length() < 1e-9);
            assert!(seen(130.0, ratio).length() < 1e-9);
            assert!(seen(60.0, ratio).length() < colour.length());
        }
        let outside = [TABLE_MIN_NM - 10.0, TABLE_MAX_NM + 10.0].map(|nm| seen(40.0, nm / 500.0));
        assert_eq!(outside, [DVec3::ZERO; 2]);
    }
}
