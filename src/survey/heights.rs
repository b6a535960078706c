//! A picture of the heights.

use crate::encode::viridis;
use crate::error::Result;
use crate::surface::HeightField;

use super::plot::{Plot, PlotRange};

/// Maximum side of the area.
const SIDE: f64 = 720.0;

/// Minimum side of the area. A narrower patch is stretched.
const THIN: f64 = 160.0;

/// Share of the pixels beyond each end of the colour scale, so that a speck of dust does not use up the scale.
const BEYOND: f64 = 0.002;

/// The heights as PNG: a map, or a profile if they vary along one axis only. Axes are in µm from the centre of the patch.
pub fn height_picture(field: &HeightField, name: &str) -> Result<Vec<u8>> {
    let (columns, rows) = (field.columns(), field.rows());
    let heights = field.heights_um();
    let along = |axis: &str, size_um: f64| PlotRange {
        low: -0.5 * size_um,
        high: 0.5 * size_um,
        name: format!("{axis}, µm"),
    };
    let (x, y) = (along("x", field.size_x_um()), along("y", field.size_y_um()));
    if heights.chunks_exact(columns).all(|line| line == &heights[..columns]) {
        return profile(&heights[..columns], x, name);
    }
    if heights.chunks_exact(columns).all(|line| line.iter().all(|h| *h == line[0])) {
        let upwards: Vec<f64> = heights.chunks_exact(columns).rev().map(|line| line[0]).collect();
        return profile(&upwards, y, name);
    }
    let longest = field.size_x_um().max(field.size_y_um());
    let side = |size_um: f64| (SIDE * size_um / longest).max(THIN).round() as i64;
    let (width, height) = (side(field.size_x_um()), side(field.size_y_um()));
    let (low, high) = inner_range(heights);
    let bar = PlotRange { low: low * 1e3, high: high * 1e3, name: "nm".to_owned() };
    let mut plot = Plot::new(&format!("heights of {name}"), [width, height], &x, &y, Some(&bar));
    for row in 0..height {
        let lines = span(row, height, rows);
        for column in 0..width {
            let cells = span(column, width, columns);
            let count = (lines.len() * cells.len()) as f64;
            let lines = lines.clone();
            let sum: f64 =
                lines.flat_map(|r| &heights[r * columns..][cells.clone()]).copied().sum();
            let share = (sum / count - low) / (high - low).max(f64::MIN_POSITIVE);
            plot.canvas.set(plot.left + column, plot.top + row, viridis(share));
        }
    }
    plot.canvas.png()
}

/// The range of pixels, of `count`, that pixel `at` of `total` shows. It has at least one pixel.
fn span(at: i64, total: i64, count: usize) -> std::ops::Range<usize> {
    let place = |at: i64| at as usize * count / total as usize;
    let (begin, end) = (place(at), place(at + 1));
    begin..end.max(begin + 1)
}

fn inner_range(heights: &[f64]) -> (f64, f64) {
    let mut sorted = heights.to_vec();
    let skip = (BEYOND * sorted.len() as f64) as usize;
    let last = sorted.len() - 1 - skip;
    let (_, &mut low, _) = sorted.select_nth_unstable_by(skip, f64::total_cmp);
    let (_, &mut high, _) = sorted.select_nth_unstable_by(last, f64::total_cmp);
    (low, high)
}

/// One period of a grating as a filled curve.
fn profile(heights: &[f64], along: PlotRange, name: &str) -> Result<Vec<u8>> {
    let range = |f: fn(f64, f64) -> f64, start| heights.iter().copied().fold(start, f);
    let (low, high) = (range(f64::min, f64::INFINITY), range(f64::max, f64::NEG_INFINITY));
    // a margin of a tenth above the highest point, and a base below the lowest
    let extent = if high > low { high - low } else { 1e-3 };
    let (floor, roof) = (low - 0.1 * extent, high + 0.1 * extent);
    let y = PlotRange { low: floor * 1e3, high: roof * 1e3, name: "height, nm".to_owned() };
    let (width, height) = (SIDE as i64, (SIDE / 3.0) as i64);
    let title = format!("profile of {name}");
    let mut plot = Plot::new(&title, [width, height], &along, &y, None);
    for column in 0..width {
        let h = heights[column as usize * heights.len() / width as usize];
        let level = ((h - floor) / (roof - floor) * height as f64).round() as i64;
        let colour = viridis((h - low) / extent * 0.85);
        let (x, top) = (plot.left + column, plot.top + height - level);
        plot.canvas.fill(x, top, 1, level, colour);
    }
    plot.canvas.png()
}
