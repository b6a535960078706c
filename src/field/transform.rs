//! Two-dimensional transforms in the convention of MATLAB's `ifft2`, restricted to a rectangle of bins.

use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use rustfft::{FftDirection, FftPlanner};
use serde::Serialize;

use crate::surface::HeightField;

/// A symmetric rectangle of frequency bins, `r` in `-r_max..=r_max` along x and `s` in `-s_max..=s_max` along y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Bins {
    /// Largest bin along x.
    pub r_max: usize,
    /// Largest bin along y.
    pub s_max: usize,
}

impl Bins {
    /// All bins at most `reach_cpum` cycles per µm from zero on either axis, and `margin` more on each side.
    pub fn reachable(size_x_um: f64, size_y_um: f64, reach_cpum: f64, margin: usize) -> Bins {
        let count = |size_um: f64| (reach_cpum * size_um + 0.5).floor() as usize + margin;
        Bins { r_max: count(size_x_um), s_max: count(size_y_um) }
    }

    /// Number of bins along x.
    pub fn width(&self) -> usize {
        2 * self.r_max + 1
    }

    /// Number of bins along y.
    pub fn height(&self) -> usize {
        2 * self.s_max + 1
    }

    /// Number of all bins.
    pub fn len(&self) -> usize {
        self.width() * self.height()
    }

    /// Always false: bin 0 always exists.
    pub fn is_empty(&self) -> bool {
        false
    }
}

/// Regular samples along one axis: `count` of them, the first at `start_um`, over a period of `period_um`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridAxis {
    /// Number of samples in a period.
    pub count: usize,
    /// Position of sample 0, µm.
    pub start_um: f64,
    /// Period, µm.
    pub period_um: f64,
}

impl GridAxis {
    /// Samples of a patch whose centre is the origin.
    pub fn centred(count: usize, period_um: f64) -> GridAxis {
        GridAxis { count, start_um: -0.5 * period_um, period_um }
    }

    /// Position of a sample, µm.
    pub fn position_um(&self, index: usize) -> f64 {
        self.start_um + index as f64 * self.period_um / self.count as f64
    }

    /// `exp(2πi r start/period)`, exact where the start is half a period.
    fn phase(&self, bin: i64) -> Complex64 {
        let turns = bin as f64 * (self.start_um / self.period_um);
        let turns = turns - turns.round();
        if turns.abs() == 0.5 {
            Complex64::new(-1.0, 0.0)
        } else {
            Complex64::cis(std::f64::consts::TAU * turns)
        }
    }

    fn wrap(&self, bin: i64) -> usize {
        bin.rem_euclid(self.count as i64) as usize
    }
}

/// The two axes of a height field, origin at the centre of the patch, y upwards.
pub fn axes(field: &HeightField) -> [GridAxis; 2] {
    [
        GridAxis::centred(field.columns(), field.size_x_um()),
        GridAxis::centred(field.rows(), field.size_y_um()),
    ]
}

/// Heights in the order of the transforms, `[y][x]` with y upwards, µm.
pub fn heights_upwards_um(field: &HeightField) -> Vec<f64> {
    field.heights_um().chunks(field.columns()).rev().flatten().copied().collect()
}

/// `1/(N·M) Σ data[y][x] · exp(+2πi(r x/Lx + s y/Ly))` for the given bins, as `[s][r]`. `x` and `y` are the positions
/// of the samples.
///
/// Bins beyond the Nyquist limit continue periodically. `data` is `[y][x]`, y upwards, and is overwritten.
pub fn ifft2(data: &mut [Complex64], [x, y]: [GridAxis; 2], bins: Bins) -> Vec<Complex64> {
    assert_eq!(data.len(), x.count * y.count, "samples of both axes");
    let mut planner = FftPlanner::new();
    let along_x = planner.plan_fft(x.count, FftDirection::Inverse);
    let along_y = planner.plan_fft(y.count, FftDirection::Inverse);
    data.par_chunks_mut(x.count * rows_per_task(y.count)).for_each(|rows| along_x.process(rows));

    let scale = 1.0 / (x.count as f64 * y.count as f64);
    let (r_max, s_max) = (bins.r_max as i64, bins.s_max as i64);
    let phase_y: Vec<Complex64> = (-s_max..=s_max).map(|s| y.phase(s) * scale).collect();
    // Columns in blocks: a block of neighbours is gathered in one pass over the rows, which keeps cache lines whole.
    const BLOCK: usize = 8;
    let data = &*data;
    let columns: Vec<Vec<Complex64>> = (0..bins.width().div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let wanted: Vec<i64> = (block * BLOCK..((block + 1) * BLOCK).min(bins.width()))
                .map(|i| i as i64 - r_max)
                .collect();
            let mut gathered = vec![Complex64::default(); wanted.len() * y.count];
            for row in 0..y.count {
                for (i, &r) in wanted.iter().enumerate() {
                    gathered[i * y.count + row] = data[row * x.count + x.wrap(r)];
                }
            }
            along_y.process(&mut gathered);
            let mut out = Vec::with_capacity(wanted.len() * bins.height());
            for (i, &r) in wanted.iter().enumerate() {
                let phase_x = x.phase(r);
                out.extend(
                    (-s_max..=s_max)
                        .zip(&phase_y)
                        .map(|(s, py)| gathered[i * y.count + y.wrap(s)] * phase_x * py),
                );
            }
            out
        })
        .collect();
    let mut out = vec![Complex64::default(); bins.len()];
    out.par_chunks_mut(bins.width()).enumerate().for_each(|(s, row)| {
        for (r, value) in row.iter_mut().enumerate() {
            *value = columns[r / BLOCK][(r % BLOCK) * bins.height() + s];
        }
    });
    out
}

fn rows_per_task(rows: usize) -> usize {
    rows.div_ceil(4 * rayon::current_num_threads()).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Comparison with the definition, for odd and even sizes, including bins beyond the Nyquist limit.
    #[test]
    fn agrees_with_the_sum_it_stands_for() {
        let (x, y) =
            (GridAxis::centred(5, 1.3), GridAxis { count: 4, start_um: 0.2, period_um: 0.9 });
        let data: Vec<Complex64> = (0..20)
            .map(|i| Complex64::new((i * i % 7) as f64, (i * 3 % 11) as f64 - 4.0))
            .collect();
        let bins = Bins { r_max: 4, s_max: 3 };
        let fast = ifft2(&mut data.clone(), [x, y], bins);
        for s in -3i64..=3 {
            for r in -4i64..=4 {
                let mut sum = Complex64::default();
                for (i, value) in data.iter().enumerate() {
                    let turns = r as f64 * x.position_um(i % 5) / 1.3
                        + s as f64 * y.position_um(i / 5) / 0.9;
                    sum += value * Complex64::cis(std::f64::consts::TAU * turns) / 20.0;
                }
                let got = fast[((s + 3) * 9 + r + 4) as usize];
                assert!((got - sum).norm() < 1e-13, "bin {r}, {s}: {got} against {sum}");
            }
        }
    }
}
