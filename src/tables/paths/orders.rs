//! Probabilities of the orders of a cell and of wavelengths.

use std::f64::consts::TAU;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use serde::Serialize;

use crate::field::transform::{Bins, axes, heights_upwards_um, ifft2};
use crate::optics::primary_shares;
use crate::optics::spectrum::Spectrum;
use crate::surface::HeightField;
use crate::tables::{PATHS, Table, TexelFormat};

/// What the probabilities of orders depend on, beside the heights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OrderPaths {
    /// The orders.
    pub bins: Bins,
    /// Range of wavelengths, nm.
    pub range_nm: [f64; 2],
    /// Smallest and largest `|w|`, under a cover times its index.
    pub steepness: [f64; 2],
    /// Part of the probability that all orders share evenly.
    pub floor: f64,
    /// Numbers of `w` and of wavelengths over which efficiencies are averaged.
    pub averaged: [usize; 2],
}

/// Number of cells of wavelengths: about one per nm.
pub fn wavelength_cells([min_nm, max_nm]: [f64; 2]) -> usize {
    (max_nm - min_nm).ceil().max(1.0) as usize
}

/// The table of paths of orders, 2-D. Row 0, one column for each order, `(s + s_max)·(2 r_max + 1) + r + r_max`: the threshold
/// and the other order of an alias table (Walker 1977; Vose 1991), the probability, 0. Rows 1 and 2, one column for each edge of
/// equal cells of wavelengths: the probability of all shorter wavelengths, then X, Y, Z there times the width of a cell; the
/// probability of the cell that begins there, then the shares of red, green and blue light.
pub fn order_paths_table(height: &HeightField, spectrum: &Spectrum, of: &OrderPaths) -> Table {
    let chances = order_chances(height, spectrum, of);
    let shape = order_paths_shape(of);
    let mut texels = vec![0.0; 4 * shape.width * shape.height];
    let alias = aliases(&chances);
    for (texel, ((threshold, other), chance)) in
        texels.chunks_exact_mut(4).zip(alias.iter().zip(&chances))
    {
        texel.copy_from_slice(&[*threshold, *other as f64, *chance, 0.0]);
    }
    let cells = wavelength_cells(of.range_nm);
    let step_nm = (of.range_nm[1] - of.range_nm[0]) / cells as f64;
    let edges: Vec<(f64, [f64; 3])> = (0..=cells)
        .map(|edge| {
            let nm = of.range_nm[0] + edge as f64 * step_nm;
            (nm, spectrum.per_nm(nm).map(|part| part * step_nm))
        })
        .collect();
    let light = |xyz: &[f64; 3]| xyz.iter().sum::<f64>().max(0.0);
    let masses: Vec<f64> =
        edges.windows(2).map(|pair| 0.5 * (light(&pair[0].1) + light(&pair[1].1))).collect();
    let whole: f64 = masses.iter().sum();
    let mut below = 0.0;
    for (edge, (nm, [x, y, z])) in edges.iter().enumerate() {
        let chance = masses.get(edge).map_or(0.0, |mass| match whole > 0.0 {
            true => mass / whole,
            false => 1.0 / cells as f64,
        });
        let [red, green, blue] = primary_shares(*nm).to_array();
        let mut put = |row: usize, texel: [f64; 4]| {
            let at = 4 * (row * shape.width + edge);
            texels[at..at + 4].copy_from_slice(&texel);
        };
        put(1, [below, *x, *y, *z]);
        put(2, [chance, red, green, blue]);
        below += chance;
    }
    Table { texels, ..shape }
}

/// The table without its texels.
pub fn order_paths_shape(of: &OrderPaths) -> Table {
    Table {
        name: "paths",
        binding: PATHS,
        format: TexelFormat::Rgba32Float,
        width: of.bins.len().max(wavelength_cells(of.range_nm) + 1),
        height: 3,
        layers: 0,
        filtered: false,
        texels: Vec::new(),
    }
}

/// Probabilities of orders: efficiencies averaged over the steepness of both directions and over the light, and the floor.
fn order_chances(height: &HeightField, spectrum: &Spectrum, of: &OrderPaths) -> Vec<f64> {
    let heights_um = heights_upwards_um(height);
    let [low, high] = of.steepness;
    let [steps, wavelengths] = of.averaged;
    let place = |i: usize, count: usize| (i as f64 + 0.5) / count as f64;
    let mut nodes = Vec::with_capacity(steps * wavelengths);
    for i in 0..wavelengths {
        let nm = of.range_nm[0] + place(i, wavelengths) * (of.range_nm[1] - of.range_nm[0]);
        let light: f64 = spectrum.per_nm(nm).iter().sum();
        for j in 0..steps {
            let share = place(j, steps);
            // the sum of two cosines is most often about half of its maximum
            let weight = (light + 1e-9) * (0.25 + share.min(1.0 - share));
            nodes.push((TAU * (low + share * (high - low)) / (nm * 1e-3), weight));
        }
    }
    let average = |mut sum: Vec<f64>, (z, weight): &(f64, f64)| {
        let mut phase: Vec<Complex64> = heights_um.iter().map(|h| Complex64::cis(-z * h)).collect();
        let amplitudes = ifft2(&mut phase, axes(height), of.bins);
        sum.iter_mut().zip(&amplitudes).for_each(|(sum, c)| *sum += weight * c.norm_sqr());
        sum
    };
    let none = || vec![0.0; of.bins.len()];
    let sums: Vec<Vec<f64>> =
        nodes.par_chunks(8).map(|chunk| chunk.iter().fold(none(), average)).collect();
    let sum = sums
        .into_iter()
        .fold(none(), |sum, part| sum.iter().zip(&part).map(|(sum, part)| sum + part).collect());
    let whole: f64 = sum.iter().sum();
    let even = of.floor / of.bins.len() as f64;
    sum.iter().map(|part| (1.0 - of.floor) * part / whole + even).collect()
}

/// For each number the threshold below which it is taken, and the number that is taken otherwise (Vose 1991).
fn aliases(chances: &[f64]) -> Vec<(f64, usize)> {
    let count = chances.len() as f64;
    let mut left: Vec<f64> = chances.iter().map(|chance| chance * count).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) =
        (0..chances.len()).partition(|i| left[*i] < 1.0);
    let mut found: Vec<(f64, usize)> = (0..chances.len()).map(|i| (1.0, i)).collect();
    while let (Some(&taker), true) = (large.last(), !small.is_empty()) {
        let Some(given) = small.pop() else { break };
        found[given] = (left[given], taker);
        left[taker] -= 1.0 - left[given];
        if left[taker] < 1.0 {
            large.pop();
            small.push(taker);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aliases_keep_probabilities() {
        let chances = [0.5, 0.01, 0.2, 0.04, 0.25];
        let found = aliases(&chances);
        let mut sums = [0.0; 5];
        for (i, (threshold, other)) in found.iter().enumerate() {
            assert!((0.0..=1.0).contains(threshold));
            sums[i] += threshold / 5.0;
            sums[*other] += (1.0 - threshold) / 5.0;
        }
        for (sum, chance) in sums.iter().zip(chances) {
            assert!((sum - chance).abs() < 1e-12, "{sums:?}");
        }
    }
}
