//! Wavelength nodes that are closer where there is more light.

use crate::plan::Wavelengths;

use super::{Sample, Spectrum};

/// The density of nodes is this power of the weights: few nodes where there is little light, but always some.
const POWER: f64 = 0.3;
/// Minimum density, relative to the maximum.
const MIN_DENSITY: f64 = 0.05;
/// Number of cells over which weights are summed, at equal steps of 1/λ.
const CELLS: usize = 4096;

/// See [`Spectrum::warped_samples`].
pub(super) fn samples(
    spectrum: &Spectrum,
    range: &Wavelengths,
    counts: &[u32],
) -> Vec<Vec<Sample>> {
    if range.max_nm <= range.min_nm {
        return counts.iter().map(|_| spectrum.samples(range)).collect();
    }
    let warp = Warp::new(spectrum, range);
    counts.iter().map(|&count| (0..count).map(|i| warp.sample(i, count)).collect()).collect()
}

/// Cumulative weights and densities from the longest wavelength on, at `CELLS + 1` equally spaced values of 1/λ.
struct Warp {
    low: f64,
    pace: f64,
    weights: Vec<[f64; 3]>,
    /// Rises from 0 to 1.
    density: Vec<f64>,
}

impl Warp {
    fn new(spectrum: &Spectrum, range: &Wavelengths) -> Warp {
        let (low, high) = (1e3 / range.max_nm, 1e3 / range.min_nm);
        let pace = (high - low) / CELLS as f64;
        let cell = |i: usize| {
            let lambda_um = 1.0 / (low + (i as f64 + 0.5) * pace);
            // dλ = λ² d(1/λ), in nm
            spectrum.per_nm(1e3 * lambda_um).map(|c| c * 1e3 * lambda_um * lambda_um * pace)
        };
        let cells: Vec<[f64; 3]> = (0..CELLS).map(cell).collect();
        let light = |cell: &[f64; 3]| cell.iter().sum::<f64>().max(0.0);
        let max = cells.iter().map(light).fold(f64::MIN_POSITIVE, f64::max);
        let mut weights = vec![[0.0; 3]];
        let mut density = vec![0.0];
        for cell in &cells {
            let (before, sum) = (weights[weights.len() - 1], density[density.len() - 1]);
            weights.push(std::array::from_fn(|c| before[c] + cell[c]));
            density.push(sum + (light(cell) / max).powf(POWER).max(MIN_DENSITY));
        }
        let all = density[CELLS];
        density.iter_mut().for_each(|sum| *sum /= all);
        Warp { low, pace, weights, density }
    }

    /// Node `i` of `count`.
    fn sample(&self, i: u32, count: u32) -> Sample {
        let part = |steps: f64| self.place(steps / f64::from(count));
        let [first, middle, last] = [0.0, 0.5, 1.0].map(|half| part(f64::from(i) + half));
        let (before, after) = (self.weight(first), self.weight(last));
        let wavenumber = self.low + middle * self.pace;
        Sample { lambda_nm: 1e3 / wavenumber, xyz: std::array::from_fn(|c| after[c] - before[c]) }
    }

    /// Position, in cells, at which the cumulative density reaches a share.
    fn place(&self, share: f64) -> f64 {
        let above = self.density.partition_point(|sum| *sum <= share).clamp(1, CELLS);
        let (before, after) = (self.density[above - 1], self.density[above]);
        (above - 1) as f64 + ((share - before) / (after - before)).clamp(0.0, 1.0)
    }

    fn weight(&self, place: f64) -> [f64; 3] {
        let index = (place as usize).min(CELLS - 1);
        let part = place - index as f64;
        std::array::from_fn(|c| {
            self.weights[index][c] * (1.0 - part) + self.weights[index + 1][c] * part
        })
    }
}
