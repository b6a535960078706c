//! Dominant periods, from the power spectrum of the heights.

use std::f64::consts::TAU;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use serde::Serialize;

use crate::surface::{HeightField, level};

/// Maximum number of peaks that are reported.
const MAX_PEAKS: usize = 5;

/// Minimum share of the power for a peak to be reported.
const MIN_SHARE: f64 = 0.01;

/// Half width of the main lobe of the Hann window, in bins. Peaks closer than this count as one, and lower frequencies
/// cannot be distinguished from the trend (Harris 1978, table I).
const HANN_BINS: usize = 2;

/// If less than this share of the power remains after the plane is subtracted, the plane is the relief itself: one
/// period of a sawtooth.
const RELIEF_LEFT: f64 = 0.05;

/// The periods of a surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Periods {
    /// Along x and y: whether the spectrum is that of the tiled patch. If not, the plane was subtracted and a Hann
    /// window applied.
    pub tiled: [bool; 2],
    /// The strongest peaks of the two-dimensional spectrum, strongest first.
    pub peaks: Vec<Peak>,
    /// Periods along x, whatever the period along y.
    pub along_x: AxisPeriods,
    /// Periods along y.
    pub along_y: AxisPeriods,
}

/// One peak of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Peak {
    /// Its period, µm.
    pub period_um: f64,
    /// Direction in which the heights repeat, across the ridges, in degrees from `+x` towards `+y`, 0 to below 180.
    pub direction_deg: f64,
    /// Its share of the power (mean square height).
    pub share: f64,
}

/// Periods along one axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisPeriods {
    /// The strongest peaks of the spectrum summed over the other axis, strongest first.
    pub peaks: Vec<Peak>,
    /// Mean period of the power within half an octave of the strongest peak, µm. It is given because scans have broad peaks.
    pub mean_um: Option<f64>,
    /// Standard deviation of this period, µm.
    pub deviation_um: Option<f64>,
    /// Share of the power in that octave.
    pub share: f64,
}

/// Finds the periods of a field. `tiled`: axes along which the field is periodic (a synthetic surface) or joins itself.
///
/// On a tiled axis the spectrum is discrete and exact. On other axes the least-squares plane is subtracted, a Hann
/// window suppresses the seam, and peaks are located between bins by a parabola through the logarithms of three bins.
/// Peaks are ranked by frequency times power, the power per octave, since the waviness of a scan has most of the power
/// but makes no colours. Shares are shares of the power itself. Sources: Harris 1978 (window), Press et al., Numerical
/// Recipes, section 13.4 (leakage).
pub fn periods(field: &HeightField, tiled: [bool; 2]) -> Periods {
    let (tiled, heights) = prepared(field, tiled);
    let spectrum = Spectrum::new(field, tiled, heights);
    Periods { tiled, peaks: spectrum.peaks(), along_x: spectrum.axis(0), along_y: spectrum.axis(1) }
}

/// Heights without mean and trend, multiplied by the window, rows upwards.
fn prepared(field: &HeightField, tiled: [bool; 2]) -> ([bool; 2], Vec<f64>) {
    let (columns, rows) = (field.columns(), field.rows());
    let plane = level::fit_plane(field);
    let slope = |is_tiled: bool, slope: f64| if is_tiled { 0.0 } else { slope };
    let (per_column, per_row) =
        (slope(tiled[0], plane.per_column_um), slope(tiled[1], plane.per_row_um));
    let (mid_x, mid_y) = (0.5 * (columns - 1) as f64, 0.5 * (rows - 1) as f64);
    let power = |heights: &[f64]| heights.iter().map(|h| h * h).sum::<f64>();
    let about = |per_column: f64, per_row: f64| -> Vec<f64> {
        let pixel =
            |i: usize| ((i % columns) as f64 - mid_x, (rows - 1 - i / columns) as f64 - mid_y);
        let upwards = field.heights_um().chunks_exact(columns).rev().flatten();
        let level = |(i, h): (usize, &f64)| {
            let (x, y) = pixel(i);
            h - plane.mean_um - per_column * x - per_row * y
        };
        upwards.enumerate().map(level).collect()
    };
    let raw = about(0.0, 0.0);
    let mut heights = about(per_column, per_row);
    if tiled == [true; 2] || power(&heights) < RELIEF_LEFT * power(&raw) {
        return ([true; 2], raw);
    }
    let window = |count: usize, is_tiled: bool| -> Vec<f64> {
        let hann = |i: usize| 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / count as f64).cos();
        (0..count).map(|i| if is_tiled { 1.0 } else { hann(i) }).collect()
    };
    let (along_x, along_y) = (window(columns, tiled[0]), window(rows, tiled[1]));
    let weight = |i: usize| along_x[i % columns] * along_y[i / columns];
    let weights: f64 = (0..heights.len()).map(weight).sum();
    let mean = heights.iter().enumerate().map(|(i, h)| h * weight(i)).sum::<f64>() / weights;
    heights.iter_mut().enumerate().for_each(|(i, h)| *h = (*h - mean) * weight(i));
    (tiled, heights)
}

/// Shares of the power of all bins but zero, `[s][r]` in the order of the transform.
struct Spectrum {
    count: [usize; 2],
    size_um: [f64; 2],
    tiled: [bool; 2],
    shares: Vec<f64>,
}

impl Spectrum {
    fn new(field: &HeightField, tiled: [bool; 2], heights: Vec<f64>) -> Spectrum {
        let count = [field.columns(), field.rows()];
        let mut planner = FftPlanner::new();
        let mut data: Vec<Complex64> = heights.iter().map(|&h| Complex64::new(h, 0.0)).collect();
        planner.plan_fft_forward(count[0]).process(&mut data);
        let mut columns = transposed(&data, count[0]);
        planner.plan_fft_forward(count[1]).process(&mut columns);
        let mut shares: Vec<f64> =
            transposed(&columns, count[1]).iter().map(Complex64::norm_sqr).collect();
        shares[0] = 0.0;
        let total: f64 = shares.iter().sum();
        // rounding errors of a flat surface are not a relief
        let scale = heights.iter().fold(0.0_f64, |max, h| max.max(h.abs())) * 1e-12;
        let floor = (scale * heights.len() as f64).powi(2);
        let of_total = |power: f64| if total > floor { power / total } else { 0.0 };
        shares.iter_mut().for_each(|power| *power = of_total(*power));
        let size_um = [field.size_x_um(), field.size_y_um()];
        Spectrum { count, size_um, tiled, shares }
    }

    /// The share of a bin, periodic in both indices.
    fn share(&self, r: i64, s: i64) -> f64 {
        let at = |bin: i64, count: usize| bin.rem_euclid(count as i64) as usize;
        self.shares[at(s, self.count[1]) * self.count[0] + at(r, self.count[0])]
    }

    /// Number of bins to either side that belong to the same line.
    fn width(&self, axis: usize) -> i64 {
        if self.tiled[axis] { 0 } else { HANN_BINS as i64 }
    }

    /// Whether a frequency is too low to be distinguished from the trend.
    fn is_trend(&self, r: i64, s: i64) -> bool {
        let bins = |bin: i64, axis| bin as f64 / if self.tiled[axis] { 1.0 } else { 3.0 };
        bins(r, 0).hypot(bins(s, 1)) < 1.0 - 1e-9
    }

    /// Frequency times power: the power per octave.
    fn rank(&self, r: i64, s: i64) -> f64 {
        (r as f64 / self.size_um[0]).hypot(s as f64 / self.size_um[1]) * self.share(r, s)
    }

    /// Whether no bin of the same line ranks higher. Among equal bins the last counts. On a tiled axis every bin is a
    /// line of its own.
    fn is_highest(&self, r: i64, s: i64) -> bool {
        let (value, wx, wy) = (self.rank(r, s), self.width(0), self.width(1));
        let mut near = (-wy..=wy).flat_map(|j| (-wx..=wx).map(move |i| (j, i)));
        near.all(|(j, i)| {
            let other = self.rank(r + i, s + j);
            if (j, i) > (0, 0) { value > other } else { value >= other }
        })
    }

    fn peaks(&self) -> Vec<Peak> {
        let [columns, rows] = self.count.map(|n| n as i64);
        // the spectrum of real heights is symmetric, so only half of it is searched, and only the right half of its middle row
        let half =
            (0..=rows / 2).flat_map(|s| ((1 - columns) / 2..=columns / 2).map(move |r| (r, s)));
        let is_half = |r: i64, s: i64| r > 0 || (s > 0 && 2 * s < rows);
        let mut found: Vec<(i64, i64)> = half
            .filter(|&(r, s)| is_half(r, s) && !self.is_trend(r, s) && self.share(r, s) > 0.0)
            .filter(|&(r, s)| self.is_highest(r, s))
            .collect();
        found.sort_by(|&(r, s), &(q, t)| {
            self.rank(q, t).total_cmp(&self.rank(r, s)).then((r, s).cmp(&(q, t)))
        });
        let (wx, wy) = (self.width(0), self.width(1));
        let peak = |(r, s): (i64, i64)| {
            let x = r as f64 + self.between(0, |d| self.share(r + d, s));
            let y = s as f64 + self.between(1, |d| self.share(r, s + d));
            let (fx, fy) = (x / self.size_um[0], y / self.size_um[1]);
            let cells = (-wy..=wy).flat_map(|j| (-wx..=wx).map(move |i| (r + i, s + j)));
            // half of a peak's power is in the mirror image of its bin, unless the two are the same bin
            let images = if (2 * r) % columns == 0 && (2 * s) % rows == 0 { 1.0 } else { 2.0 };
            Peak {
                period_um: 1.0 / fx.hypot(fy),
                direction_deg: direction_deg(fx, fy),
                share: images * cells.map(|(r, s)| self.share(r, s)).sum::<f64>(),
            }
        };
        strongest(found.into_iter().map(peak))
    }

    /// Periods along x (0) or y (1).
    fn axis(&self, axis: usize) -> AxisPeriods {
        let count = self.count[axis];
        let sum = |bin: usize| -> f64 {
            (0..self.count[1 - axis])
                .map(|other| match axis {
                    0 => self.shares[other * count + bin],
                    _ => self.shares[bin * self.count[0] + other],
                })
                .sum()
        };
        let line: Vec<f64> = (0..count).map(sum).collect();
        let share = |bin: i64| line[bin.rem_euclid(count as i64) as usize];
        let both = |bin: i64| if 2 * bin == count as i64 { share(bin) } else { 2.0 * share(bin) };
        let (first, last) = (if self.tiled[axis] { 1 } else { 3 }, count as i64 / 2);
        let width = self.width(axis);
        let rank = |bin: i64| bin as f64 * share(bin);
        let mut found: Vec<i64> = (first..=last)
            .filter(|&b| share(b) > 0.0)
            .filter(|&b| (1..=width).all(|d| rank(b) > rank(b + d) && rank(b) >= rank(b - d)))
            .collect();
        found.sort_by(|&a, &b| rank(b).total_cmp(&rank(a)).then(a.cmp(&b)));
        let place = |bin: i64| bin as f64 + self.between(axis, |d| share(bin + d));
        let peak = |&bin: &i64| Peak {
            period_um: self.size_um[axis] / place(bin),
            direction_deg: 90.0 * axis as f64,
            share: (-width..=width).filter(|d| bin + d <= last).map(|d| both(bin + d)).sum(),
        };
        let peaks = strongest(found.iter().map(peak));
        let Some(strongest) = peaks.first() else {
            return AxisPeriods { peaks, mean_um: None, deviation_um: None, share: 0.0 };
        };
        let around = self.size_um[axis] / strongest.period_um;
        let octave = |b: &i64| (*b as f64 / around).log2().abs() < 0.5;
        let (mut sum, mut first_moment, mut second) = (0.0, 0.0, 0.0);
        for bin in (first..=last).filter(octave) {
            let period_um = self.size_um[axis] / bin as f64;
            sum += both(bin);
            first_moment += both(bin) * period_um;
            second += both(bin) * period_um * period_um;
        }
        let mean_um = first_moment / sum;
        let deviation_um = (second / sum - mean_um * mean_um).max(0.0).sqrt();
        AxisPeriods { peaks, mean_um: Some(mean_um), deviation_um: Some(deviation_um), share: sum }
    }

    /// Position of a line between bins, relative to the bin of the maximum. On a tiled axis it is the bin itself.
    fn between(&self, axis: usize, share: impl Fn(i64) -> f64) -> f64 {
        let [before, at, after] = [-1, 0, 1].map(|d| share(d).max(f64::MIN_POSITIVE).ln());
        let curvature = before - 2.0 * at + after;
        if self.tiled[axis] || curvature >= 0.0 {
            return 0.0;
        }
        (0.5 * (before - after) / curvature).clamp(-0.5, 0.5)
    }
}

/// From `+x` towards `+y`, 0 to below 180.
fn direction_deg(x: f64, y: f64) -> f64 {
    let degrees = y.atan2(x).to_degrees().rem_euclid(180.0);
    if degrees > 179.9999 { 0.0 } else { degrees }
}

/// The peaks to report, from peaks in descending rank. Peaks far down the list are too weak.
fn strongest(peaks: impl Iterator<Item = Peak>) -> Vec<Peak> {
    peaks.take(8 * MAX_PEAKS).filter(|peak| peak.share >= MIN_SHARE).take(MAX_PEAKS).collect()
}

fn transposed(data: &[Complex64], width: usize) -> Vec<Complex64> {
    let height = data.len() / width;
    (0..width).flat_map(|x| (0..height).map(move |y| data[y * width + x])).collect()
}
