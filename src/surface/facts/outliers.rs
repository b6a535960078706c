//! Dust and spikes: few pixels that make most of the height range.

use crate::error::Result;
use crate::surface::{HeightField, level};

/// Percentages clipped at each end that are tried. Above the last, a feature of the surface is as likely as dust.
const PERCENTS: [f64; 5] = [0.05, 0.1, 0.2, 0.5, 1.0];

/// Maximum height range after clipping, relative to the range before, for what was clipped to count as dust.
const MAX_SHARE: f64 = 0.5;

/// Pixels that stand far outside the heights of all others.
#[derive(Clone, Debug, PartialEq)]
pub struct Outliers {
    /// Percentage to clip at each end, `clip_percent`.
    pub percent: f64,
    /// Number of pixels that are outside the clipped range by more than half of it.
    pub pixels: usize,
    /// Their share of all pixels.
    pub share: f64,
    /// The largest distance of one of them from the clipped range, µm.
    pub farthest_um: f64,
    /// The heights after clipping.
    pub clipped: HeightField,
}

/// The outliers, if clipping at most 1 % of the pixels at each end halves the height range. It sorts copies of the heights.
pub fn outliers(field: &HeightField) -> Result<Option<Outliers>> {
    let (low, high) = field.range_um();
    for percent in PERCENTS {
        let (clipped, _) = level::clip(field.clone(), percent, "heights")?;
        let (bottom, top) = clipped.range_um();
        let width = top - bottom;
        if width <= 0.0 || width > MAX_SHARE * (high - low) {
            continue;
        }
        let outside = |h: &f64| (bottom - h).max(h - top);
        let pixels = field.heights_um().iter().filter(|h| outside(h) > 0.5 * width).count();
        return Ok(Some(Outliers {
            percent,
            pixels,
            share: pixels as f64 / field.heights_um().len() as f64,
            farthest_um: (bottom - low).max(high - top),
            clipped,
        }));
    }
    Ok(None)
}
