//! A picture of where the surface sends light: the power of its orders at one wavelength.

use std::f64::consts::TAU;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use crate::encode::viridis;
use crate::error::Result;
use crate::field::transform::{Bins, axes, heights_upwards_um, ifft2};
use crate::optics::{Matter, REFERENCE_NM};
use crate::surface::HeightField;

use super::canvas::NIGHT;
use super::plot::{Plot, PlotRange};

/// Wavelength of the picture, nm; both directions along the normal, so `w = -2`.
const LAMBDA_NM: f64 = REFERENCE_NM;

/// Side of the area, pixels.
const SIDE: i64 = 720;

/// Half width of the picture, relative to the maximum frequency that a pair of directions can reach.
const BEYOND: f64 = 1.12;

/// Half size of an order in pixels, if orders are far apart.
const DOT: f64 = 5.0;

/// Minimum and maximum range of the colour scale below the strongest order, dB.
const MIN_DB: f64 = 30.0;
const MAX_DB: f64 = 80.0;

/// Powers below this are rounding errors, dB.
const ROUNDING_DB: f64 = -140.0;

/// `|c_rs(z)|²` of `exp(i z h)` as PNG, in decibels relative to a mirror, at 550 nm and both directions along the
/// normal, below the cover if there is one. Frequency zero is in the middle.
///
/// The circle `|f| = 2/λ` contains all frequencies that pairs of directions can reach. Orders that are far apart are
/// drawn as dots. A pixel with several orders shows their mean power.
pub fn spectrum_picture(field: &HeightField, matter: &Matter, name: &str) -> Result<Vec<u8>> {
    let lambda_um = LAMBDA_NM * 1e-3;
    let reach_cpum = 2.0 / lambda_um;
    let shown_cpum = BEYOND * reach_cpum;
    let size_um = [field.size_x_um(), field.size_y_um()];
    let bins = Bins::reachable(size_um[0], size_um[1], shown_cpum, 1);
    let z = -matter.max_z(LAMBDA_NM);
    let mut phase: Vec<Complex64> =
        heights_upwards_um(field).par_iter().map(|h| Complex64::cis(z * h)).collect();
    let power: Vec<f64> =
        ifft2(&mut phase, axes(field), bins).iter().map(Complex64::norm_sqr).collect();
    let (floor_db, top_db) = decibel_range(&power);

    let scale = |axis: &str| PlotRange {
        low: -shown_cpum,
        high: shown_cpum,
        name: format!("{axis}, cycles per µm"),
    };
    let bar = PlotRange { low: floor_db, high: top_db, name: "dB".to_owned() };
    let title = format!("orders of {name}, {LAMBDA_NM} nm along the normal");
    let mut plot = Plot::new(&title, [SIDE, SIDE], &scale("fx"), &scale("fy"), Some(&bar));
    let per_pixel = 2.0 * shown_cpum / SIDE as f64;
    let lines = [0, 1].map(|axis| {
        Line::all(size_um[axis], shown_cpum, per_pixel, [bins.r_max, bins.s_max][axis])
    });
    let is_sparse = lines.iter().any(|line| line.is_sparse);
    for (row, of_row) in lines[1].places.iter().rev().enumerate() {
        for (column, of_column) in lines[0].places.iter().enumerate() {
            let within = !is_sparse || of_row.away.hypot(of_column.away) <= 1.0;
            let count = (of_row.bins.len() * of_column.bins.len()) as f64;
            let sum: f64 = of_row
                .bins
                .clone()
                .flat_map(|s| &power[s * bins.width()..][of_column.bins.clone()])
                .sum();
            let db = decibels(sum / count);
            let colour = if within && count > 0.0 && db >= floor_db - 20.0 {
                viridis((db - floor_db) / (top_db - floor_db))
            } else {
                NIGHT
            };
            plot.canvas.set(plot.left + column as i64, plot.top + row as i64, colour);
        }
    }
    circle(&mut plot, reach_cpum / per_pixel);
    plot.canvas.png()
}

fn decibels(power: f64) -> f64 {
    10.0 * power.max(1e-300).log10()
}

/// Range from the typical order to the strongest. Rounding errors in place of absent orders do not count.
fn decibel_range(power: &[f64]) -> (f64, f64) {
    let lit = power.iter().map(|p| decibels(*p)).filter(|db| *db > ROUNDING_DB);
    let mut sorted: Vec<f64> = lit.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    // by Parseval's theorem some order has power, but it may be outside the picture
    let top = sorted.last().copied().unwrap_or(0.0).ceil();
    let bulk = sorted.get(sorted.len() / 100).copied().unwrap_or(0.0).floor();
    (bulk.clamp(top - MAX_DB, top - MIN_DB), top)
}

/// The bins that one pixel shows along an axis.
struct Place {
    /// Indices of bins in the table.
    bins: std::ops::Range<usize>,
    /// Distance from the bin's centre, in half sizes of a dot.
    away: f64,
}

/// The pixels along an axis, from the low end.
struct Line {
    places: Vec<Place>,
    /// Whether orders are far enough apart to be drawn as dots.
    is_sparse: bool,
}

impl Line {
    fn all(size_um: f64, shown_cpum: f64, per_pixel: f64, middle: usize) -> Line {
        let bins_per_pixel = size_um * per_pixel;
        let place = |pixel: i64| {
            let edge = (-shown_cpum + pixel as f64 * per_pixel) * size_um + middle as f64;
            let centre = edge + 0.5 * bins_per_pixel;
            let nearest = centre.round();
            let away = (centre - nearest).abs() / bins_per_pixel / DOT;
            let last = 2 * middle + 1;
            let bins = if bins_per_pixel > 1.0 {
                let at = |edge: f64| (edge.round().max(0.0) as usize).min(last);
                at(edge)..at(edge + bins_per_pixel)
            } else {
                let nearest = (nearest.max(0.0) as usize).min(last - 1);
                nearest..nearest + 1
            };
            Place { bins, away }
        };
        Line {
            places: (0..SIDE).map(place).collect(),
            is_sparse: bins_per_pixel * (2.0 * DOT) < 1.0,
        }
    }
}

/// A dashed circle about the middle of the area.
fn circle(plot: &mut Plot, radius: f64) {
    let middle = 0.5 * SIDE as f64;
    let steps = (TAU * radius * 2.0).ceil();
    for i in 0..steps as i64 {
        let angle = TAU * i as f64 / steps;
        // sixty dashes and sixty gaps
        if (angle / TAU * 120.0) as i64 % 2 == 0 {
            let (x, y) = (middle + radius * angle.cos(), middle - radius * angle.sin());
            for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)] {
                let (x, y) = ((x + dx) as i64, (y + dy) as i64);
                plot.canvas.set(plot.left + x, plot.top + y, [255, 255, 255]);
            }
        }
    }
}
