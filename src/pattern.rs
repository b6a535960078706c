//! Patterns: what a foil's grating is at each place.
//!
//! A foil has one profile, the compiled one, and at each place its own angle, period and depth. A *pattern map* holds them per
//! texel. It is a PNG file of numbers ([`PatternMap::decode`]), glTF's texture of anisotropy ([`PatternMap::from_anisotropy`]), or
//! drawn by formula ([`Drawing`]).
//!
//! **Frame.** Row 0 is the top of the picture and `v = 0`, as in glTF. The tangent points along `+u`, to the right; the bitangent
//! points up, towards row 0. Angles count from the tangent towards the bitangent, so counter-clockwise as one sees the picture.
//!
//! **Mips.** Far away a pixel sees many texels. Their radiances add up, not their parameters: the mean of 1° and 359° is not 180°.
//! [`Moments`] are sums that may be filtered linearly. From them follow the mean direction and its spread, and the mean period and its spread.

mod anisotropy;
mod draw;
mod file;
mod moments;
mod preview;

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use crate::error::{Error, Result};

pub use anisotropy::Anisotropy;
pub use draw::{Drawing, Groove, Kind, Stencil};
pub use file::{Bits, DEPTH_KEY, GivenRanges, PERIOD_KEY};
pub use moments::{MAX_ANGLE_SPREAD_RAD, MomentMap, Moments};
pub use preview::Sketch;

/// Maximum number of rows and of columns of a map.
pub const MAX_SIDE: usize = 8192;
/// What a period ratio may be.
pub const PERIOD_RATIOS: RangeInclusive<f64> = 1e-3..=1e3;
/// What a depth ratio may be. At 0 the foil is flat.
pub const DEPTH_RATIOS: RangeInclusive<f64> = 0.0..=1e3;

/// The pattern of one texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel {
    /// Direction in which the profile varies, across the grooves: from the tangent towards the bitangent, in `[0, 2π)`.
    pub angle_rad: f64,
    /// Period over that of the compiled profile, in [`PERIOD_RATIOS`].
    pub period_ratio: f64,
    /// Depth over that of the compiled profile, in [`DEPTH_RATIOS`].
    pub depth_ratio: f64,
    /// Share of the area that is foil, in `[0, 1]`. Without foil the other numbers mean nothing.
    pub mask: f64,
    /// Standard deviation of the angle, from 0 to [`MAX_ANGLE_SPREAD_RAD`].
    pub angle_spread_rad: f64,
    /// Standard deviation of the logarithm of the period, from 0.
    pub ln_period_spread: f64,
}

impl Default for Texel {
    /// The compiled profile as it is.
    fn default() -> Texel {
        Texel {
            angle_rad: 0.0,
            period_ratio: 1.0,
            depth_ratio: 1.0,
            mask: 1.0,
            angle_spread_rad: 0.0,
            ln_period_spread: 0.0,
        }
    }
}

/// From where to where the ratios of a map or of a variant go; each pair ascends or is one number twice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranges {
    /// Lowest and highest period ratio.
    pub period_ratio: [f64; 2],
    /// Lowest and highest depth ratio.
    pub depth_ratio: [f64; 2],
}

impl Ranges {
    /// Refuses ranges that descend or leave [`PERIOD_RATIOS`] and [`DEPTH_RATIOS`]. `subject` names their origin in errors.
    pub fn check(&self, subject: &str) -> Result<()> {
        check_range("period_ratio", self.period_ratio, &PERIOD_RATIOS, subject)?;
        check_range("depth_ratio", self.depth_ratio, &DEPTH_RATIOS, subject)
    }
}

fn check_range(
    key: &str,
    [low, high]: [f64; 2],
    limits: &RangeInclusive<f64>,
    subject: &str,
) -> Result<()> {
    if low <= high && limits.contains(&low) && limits.contains(&high) {
        return Ok(());
    }
    let (least, most) = (limits.start(), limits.end());
    let cause = format!("{key} is {low} to {high}");
    let remedy = format!("give two numbers from {least} to {most}, the lower one first");
    Err(Error::new(subject, cause).remedy(remedy))
}

/// The pattern of a foil, texel by texel.
#[derive(Clone, Debug, PartialEq)]
pub struct PatternMap {
    width: usize,
    height: usize,
    texels: Vec<Texel>,
}

impl PatternMap {
    /// A map of texels `[row][column]`. Angles are brought into `[0, 2π)`.
    ///
    /// What is refused: a side of 0 or above [`MAX_SIDE`], a wrong number of texels, and numbers that are not finite or outside of
    /// the ranges that [`Texel`] states. `subject` names the map in errors.
    pub fn new(
        width: usize,
        height: usize,
        mut texels: Vec<Texel>,
        subject: &str,
    ) -> Result<PatternMap> {
        check_size(width, height, subject)?;
        if texels.len() != width * height {
            let cause = format!("has {} texels for {width} × {height}", texels.len());
            return Err(Error::new(subject, cause).remedy("give one texel for each place"));
        }
        for (i, texel) in texels.iter_mut().enumerate() {
            if let Some((name, value)) = texel.fault() {
                let (column, row) = (i % width, i / width);
                let cause = format!("{name} is {value} at column {column}, row {row}");
                return Err(Error::new(subject, cause).remedy(
                    "angles are finite, ratios positive and at most 1000, masks from 0 to 1",
                ));
            }
            texel.angle_rad = turn(texel.angle_rad);
        }
        Ok(PatternMap { width, height, texels })
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All texels, `[row][column]`, rows from the top.
    pub fn texels(&self) -> &[Texel] {
        &self.texels
    }

    /// The ratios that occur on foil; `None` without any foil.
    pub fn ranges(&self) -> Option<Ranges> {
        let foil = || self.texels.iter().filter(|texel| texel.mask > 0.0);
        foil().next()?;
        let range = |of: fn(&Texel) -> f64| {
            let wider = |[low, high]: [f64; 2], value: f64| [low.min(value), high.max(value)];
            foil().map(of).fold([f64::INFINITY, f64::NEG_INFINITY], wider)
        };
        Some(Ranges {
            period_ratio: range(|t| t.period_ratio),
            depth_ratio: range(|t| t.depth_ratio),
        })
    }

    /// Share of the whole area that is foil.
    pub fn foil_share(&self) -> f64 {
        self.texels.iter().map(|texel| texel.mask).sum::<f64>() / self.texels.len() as f64
    }

    /// Brings all ratios into what a variant can show. Returns how many texels with foil this changed: a caller that ignores the
    /// number shows other colours than the map asks for.
    #[must_use]
    pub fn clamp(&mut self, ranges: &Ranges) -> usize {
        let within = |value: f64, [low, high]: [f64; 2]| value.max(low).min(high);
        let mut changed = 0;
        for texel in &mut self.texels {
            let before = *texel;
            texel.period_ratio = within(before.period_ratio, ranges.period_ratio);
            texel.depth_ratio = within(before.depth_ratio, ranges.depth_ratio);
            changed += usize::from(before.mask > 0.0 && *texel != before);
        }
        changed
    }
}

impl Texel {
    /// A number that is not what it may be, with its name.
    fn fault(&self) -> Option<(&'static str, f64)> {
        let of = |name, value, good: bool| (!good).then_some((name, value));
        let (spread, ln_spread) = (self.angle_spread_rad, self.ln_period_spread);
        of("the angle", self.angle_rad, self.angle_rad.is_finite())
            .or(of(
                "the period ratio",
                self.period_ratio,
                PERIOD_RATIOS.contains(&self.period_ratio),
            ))
            .or(of("the depth ratio", self.depth_ratio, DEPTH_RATIOS.contains(&self.depth_ratio)))
            .or(of("the mask", self.mask, (0.0..=1.0).contains(&self.mask)))
            .or(of(
                "the spread of the angle",
                spread,
                (0.0..=MAX_ANGLE_SPREAD_RAD).contains(&spread),
            ))
            .or(of(
                "the spread of the period",
                ln_spread,
                ln_spread.is_finite() && ln_spread >= 0.0,
            ))
    }
}

/// An angle within `[0, 2π)`.
fn turn(angle_rad: f64) -> f64 {
    let turned = angle_rad.rem_euclid(TAU);
    // of a tiny negative angle the remainder is rounded to the whole turn
    if turned < TAU { turned } else { 0.0 }
}

/// Refuses an empty or a large map. It is asked before memory is allocated.
fn check_size(width: usize, height: usize, subject: &str) -> Result<()> {
    if width >= 1 && height >= 1 && width.max(height) <= MAX_SIDE {
        return Ok(());
    }
    let cause = format!("has {width} × {height} texels; a side may have 1 to {MAX_SIDE}");
    Err(Error::new(subject, cause).remedy("scale it, or divide it into several maps"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_mean_nothing_are_refused() {
        let good = Texel { angle_rad: -1e-20, ..Texel::default() };
        let map = PatternMap::new(1, 1, vec![good], "map").unwrap();
        assert_eq!(map.texels()[0].angle_rad, 0.0);
        for (bad, wanted) in [
            (Texel { angle_rad: f64::NAN, ..good }, "the angle is NaN at column 1, row 1"),
            (Texel { period_ratio: 0.0, ..good }, "the period ratio is 0"),
            (Texel { period_ratio: f64::INFINITY, ..good }, "the period ratio is inf"),
            (Texel { depth_ratio: -0.1, ..good }, "the depth ratio is -0.1"),
            (Texel { mask: 1.1, ..good }, "the mask is 1.1"),
            (Texel { mask: f64::NAN, ..good }, "the mask is NaN"),
            (Texel { angle_spread_rad: 2.0, ..good }, "the spread of the angle is 2"),
            (Texel { ln_period_spread: f64::NAN, ..good }, "the spread of the period is NaN"),
        ] {
            let text = PatternMap::new(2, 2, vec![good, good, good, bad], "map").unwrap_err();
            assert!(text.to_string().contains(wanted), "{text}");
            assert!(text.advice().is_some());
        }
        for (width, height, texels) in [(0, 1, 0), (1, 0, 0), (8193, 1, 8193), (2, 2, 3)] {
            assert!(PatternMap::new(width, height, vec![good; texels], "map").is_err());
        }
    }

    #[test]
    fn clamping_counts_what_it_changes_on_foil() {
        let texel = |period_ratio, depth_ratio, mask| Texel {
            period_ratio,
            depth_ratio,
            mask,
            ..Texel::default()
        };
        let texels = vec![
            texel(0.4, 1.0, 1.0),
            texel(1.0, 3.0, 0.5),
            texel(9.0, 1.0, 0.0),
            texel(1.0, 1.0, 1.0),
        ];
        let mut map = PatternMap::new(2, 2, texels, "map").unwrap();
        let ranges = Ranges { period_ratio: [0.5, 2.0], depth_ratio: [0.5, 1.5] };
        assert_eq!(map.clamp(&ranges), 2);
        assert_eq!(map.clamp(&ranges), 0);
        let found = map.ranges().unwrap();
        assert_eq!(found, Ranges { period_ratio: [0.5, 1.0], depth_ratio: [1.0, 1.5] });
        assert_eq!(map.foil_share(), 0.625);
    }

    #[test]
    fn ranges_that_descend_are_refused() {
        let ranges = |period_ratio, depth_ratio| Ranges { period_ratio, depth_ratio };
        assert!(ranges([0.5, 2.0], [0.0, 0.0]).check("x").is_ok());
        for bad in [
            ranges([2.0, 0.5], [1.0, 1.0]),
            ranges([f64::NAN, 0.5], [1.0, 1.0]),
            ranges([0.0, 1.0], [1.0, 1.0]),
            ranges([1.0, 1.0], [-1.0, 1.0]),
            ranges([1.0, 1.0], [1.0, f64::INFINITY]),
        ] {
            assert!(bad.check("x").is_err(), "{bad:?}");
        }
    }
}
