//! Levels of a panorama for whole shaders, see `templates/surroundings.wgsl`.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::Panorama;
use crate::light::Surroundings;

/// Number of rows of the two finest levels.
pub const ROWS: usize = 512;
/// Number of levels. The first is not blurred; the others have 512, 256, … rows.
pub const LEVELS: usize = 9;
/// Standard deviation of the second level, radians: 1.5 times the angle between its rows. Each further one is twice as wide.
pub const FIRST_SPREAD_RAD: f64 = 1.5 * PI / ROWS as f64;
/// Rows of the picture with all levels and their frames.
pub const HEIGHT: usize = 3 * ROWS + 2 * LEVELS - 2 * (ROWS >> (LEVELS - 1));
/// Columns of that picture.
pub const WIDTH: usize = 2 * ROWS + 2;

/// Where the blur of a level is cut off, in standard deviations.
const REACH: f64 = 3.7;

/// A panorama in levels of blur. Between levels and between texels it is as a shader has it.
#[derive(Clone, Debug)]
pub struct Filtered {
    levels: Vec<Panorama>,
}

/// Number of rows of a level.
fn rows_of(level: usize) -> usize {
    ROWS >> level.saturating_sub(1)
}

/// Row of the picture at which the frame of a level begins.
fn first_row(level: usize) -> usize {
    (0..level).map(|level| rows_of(level) + 2).sum()
}

impl Filtered {
    /// Blurs any surroundings that can be asked for a spread themselves.
    pub fn of(surroundings: &dyn Surroundings) -> Filtered {
        let level = |level: usize| {
            Panorama::drawn(rows_of(level), &|d| surroundings.seen(d, spread_rad(level)))
        };
        Filtered { levels: (0..LEVELS).map(level).collect() }
    }

    /// Blurs a function of the direction. The first level is its mean over the pixels of a picture of [`ROWS`] rows, from
    /// `finer` × `finer` places in each.
    pub fn blurred(sharp: &(dyn Fn(DVec3) -> DVec3 + Sync), finer: usize) -> Filtered {
        let rows = ROWS * finer;
        let pixel = |i: usize| {
            let (row, column) = (i / (2 * ROWS) * finer, i % (2 * ROWS) * finer);
            let parts =
                (0..finer * finer).map(|k| middle(rows, row + k / finer, column + k % finer));
            let sum: DVec3 = parts.map(sharp).sum();
            (sum / (finer * finer) as f64).as_vec3().to_array()
        };
        let texels = (0..2 * ROWS * ROWS).into_par_iter().map(pixel).collect();
        let mut levels = vec![Panorama { width: 2 * ROWS, height: ROWS, texels }];
        for level in 1..LEVELS {
            let before = &levels[level - 1];
            let (from, to) = (spread_rad(level - 1), spread_rad(level));
            levels.push(before.blurred(rows_of(level), (to * to - from * from).sqrt()));
        }
        Filtered { levels }
    }

    /// The sum of two.
    #[must_use]
    pub fn plus(mut self, other: &Filtered) -> Filtered {
        for (level, other) in self.levels.iter_mut().zip(&other.levels) {
            for (texel, other) in level.texels.iter_mut().zip(&other.texels) {
                *texel = std::array::from_fn(|c| texel[c] + other[c]);
            }
        }
        self
    }

    /// All levels with their frames, `[row][column]`, [`WIDTH`] × [`HEIGHT`] texels.
    pub fn picture(&self) -> Vec<[f32; 3]> {
        let mut texels = vec![[0.0; 3]; WIDTH * HEIGHT];
        for (level, panorama) in self.levels.iter().enumerate() {
            let Panorama { width, height, .. } = *panorama;
            for row in 0..height + 2 {
                for column in 0..width + 2 {
                    let from = row.saturating_sub(1).min(height - 1) * width
                        + (column + width - 1) % width;
                    let to = (first_row(level) + row) * WIDTH + column;
                    texels[to] = panorama.texels[from];
                }
            }
        }
        texels
    }
}

/// Standard deviation of a level, radians.
fn spread_rad(level: usize) -> f64 {
    match level {
        0 => 0.0,
        _ => FIRST_SPREAD_RAD * (1 << (level - 1)) as f64,
    }
}

impl Surroundings for Filtered {
    fn seen(&self, direction: DVec3, spread_rad: f64) -> DVec3 {
        let at = |level: usize| self.levels[level].towards(direction);
        let blur = (spread_rad / FIRST_SPREAD_RAD).powi(2);
        if blur < 1.0 {
            return at(0).lerp(at(1), blur);
        }
        let level = ((0.5 * blur.log2()).floor() as usize + 1).min(LEVELS - 2);
        let own = 4.0_f64.powi(level as i32 - 1);
        at(level).lerp(at(level + 1), ((blur - own) / (3.0 * own)).clamp(0.0, 1.0))
    }
}

impl Panorama {
    /// A picture of a function of the direction, twice as wide as high.
    pub fn drawn(rows: usize, radiance: &(dyn Fn(DVec3) -> DVec3 + Sync)) -> Panorama {
        let texels = (0..2 * rows * rows)
            .into_par_iter()
            .map(|i| radiance(middle(rows, i / (2 * rows), i % (2 * rows))).as_vec3().to_array());
        Panorama { width: 2 * rows, height: rows, texels: texels.collect() }
    }

    /// Blurred to a standard deviation on each axis, with as many rows or half as many. The weights of a row are the same for all
    /// its columns.
    fn blurred(&self, rows: usize, sigma_rad: f64) -> Panorama {
        let (own, width) = (self.height, self.width);
        let (pixel_rad, ratio) = (PI / own as f64, own / rows);
        let reach_rad = (REACH * sigma_rad).min(PI);
        let line = |row: usize| {
            let theta = (row as f64 + 0.5) / rows as f64 * PI;
            let first = ((theta - reach_rad) / pixel_rad).floor().max(0.0) as usize;
            let last = (((theta + reach_rad) / pixel_rad).ceil() as usize).min(own - 1);
            let (mut sums, mut total) = (vec![DVec3::ZERO; 2 * rows], 0.0);
            for from in first..=last {
                let other = (from as f64 + 0.5) * pixel_rad;
                // half the angle about the axis within which the row is near enough
                let sines = (theta.sin() * other.sin()).max(1e-12);
                let cosine = (reach_rad.cos() - theta.cos() * other.cos()) / sines;
                let half_rad = if cosine <= -1.0 { PI } else { cosine.min(1.0).acos() };
                let half = (half_rad / pixel_rad).ceil() as usize + ratio;
                let steps = (2 * half + ratio).min(width);
                let texels = &self.texels[from * width..(from + 1) * width];
                for step in 0..steps {
                    let offset = step as f64 - (steps / 2) as f64;
                    let turn = (offset + 0.5 - 0.5 * ratio as f64) * pixel_rad;
                    let cosine = theta.cos() * other.cos() + sines * turn.cos();
                    let weight = other.sin() * ((cosine - 1.0) / (sigma_rad * sigma_rad)).exp();
                    total += weight;
                    for (column, sum) in sums.iter_mut().enumerate() {
                        let at = (column * ratio + width + step - steps / 2) % width;
                        *sum += weight * DVec3::from(texels[at].map(f64::from));
                    }
                }
            }
            sums.into_iter()
                .map(move |sum| (sum / total.max(f64::MIN_POSITIVE)).as_vec3().to_array())
        };
        let texels = (0..rows).into_par_iter().flat_map_iter(line).collect();
        Panorama { width: 2 * rows, height: rows, texels }
    }
}

/// Direction of the middle of a pixel of a picture of `rows` rows.
fn middle(rows: usize, row: usize, column: usize) -> DVec3 {
    Panorama::direction([2 * rows, rows], row as f64 + 0.5, column as f64 + 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{Lobe, Sky};
    use crate::optics::direction;

    /// Levels that are blurred one from the other are those of the formula.
    #[test]
    fn a_blurred_lobe_is_the_lobe_of_the_formula() {
        let lobe = |theta, phi, sigma_rad, radiance| Lobe {
            axis: direction(theta, phi),
            sigma_rad,
            radiance,
        };
        let sky = Sky {
            constant: DVec3::new(0.1, 0.2, 0.3),
            lobes: [
                lobe(2.0, 50.0, 0.05, DVec3::new(3.0, 1.0, 0.2)),
                lobe(80.0, 179.0, 0.1, DVec3::new(0.0, 1.0, 4.0)),
            ],
        };
        let filtered = Filtered::blurred(&|d| sky.seen(d, 0.0), 1);
        let mut worst = [0.0_f64; 2];
        for i in 0..4000 {
            let part = |power: i32| (0.5 + f64::from(i) / 1.2207_f64.powi(power)).fract();
            let (near, spread) = (sky.lobes[i as usize % 2].axis, 0.4 * part(3) * part(3));
            let to =
                (near + 0.5 * part(4) * direction(180.0 * part(1), 360.0 * part(2))).normalize();
            let apart =
                |other: f64| (filtered.seen(to, spread) - sky.seen(to, other)).abs().max_element();
            worst = [worst[0].max(apart(spread)), worst[1].max(apart(1.3 * spread))];
        }
        // half way between two levels, 5 % of the brightest; the control: another spread
        assert!(worst[0] < 0.2 && worst[1] > 0.5, "{worst:?}");
        // what it sees is what is in the picture that shaders read
        let picture = filtered.picture();
        let texel = |level: usize, row: usize, column: usize| {
            picture[(first_row(level) + row) * WIDTH + column]
        };
        for (level, panorama) in filtered.levels.iter().enumerate() {
            let (w, h) = (panorama.width, panorama.height);
            assert_eq!(texel(level, 1, 1), panorama.texels[0]);
            assert_eq!(texel(level, h, w), panorama.texels[w * h - 1]);
            assert_eq!(texel(level, 1, 0), panorama.texels[w - 1]);
            assert_eq!(texel(level, h + 1, w + 1), panorama.texels[w * (h - 1)]);
            let formula = if level == 0 { 0 } else { 3 * ROWS + 2 * level - 2 * rows_of(level) };
            assert_eq!(first_row(level), formula, "the formula of the template");
        }
        assert_eq!(first_row(LEVELS), HEIGHT);
    }
}
