//! Pooling of bins. An ensemble is a sum of intensities under a Gaussian. A wide Gaussian is the convolution of two: the
//! first one is applied to the bins in advance, on a coarser grid, and the sum under the second one has few bins left.

use std::f64::consts::TAU;

use crate::field::transform::Bins;

/// Standard deviation of the Gaussian that is applied in advance, in bins of the coarser grid. A Gaussian of this width is
/// summed at whole numbers with an error of 2 exp(-2π² 0.8²) = 6e-6.
pub(super) const POOL_SIGMA: f64 = 0.8;
/// Least standard deviation of the whole, in bins of the coarser grid: what remains is as wide as [`POOL_SIGMA`], too.
const WHOLE_SIGMA: f64 = 1.2;
/// Number of standard deviations at which the Gaussian is cut; there it is 4e-6.
const REACH: f64 = 5.0;

/// Number of bins along an axis that become one. 1: none are pooled. `sigma_bins`: standard deviation of the narrowest
/// intensity.
pub(super) fn factor(sigma_bins: f64) -> usize {
    (sigma_bins / WHOLE_SIGMA).floor().max(1.0) as usize
}

/// Variance of what remains of a Gaussian of that variance, both in bins of the coarser grid, and its weight.
pub(super) fn remaining(variance: f64) -> (f64, f64) {
    let rest = variance - POOL_SIGMA * POOL_SIGMA;
    (rest, (variance / (TAU * rest)).sqrt() / POOL_SIGMA)
}

/// Pools `[s][r][number]` along both axes by the factors.
pub(super) fn pool(
    numbers: &[f32],
    bins: Bins,
    padded: usize,
    [x, y]: [usize; 2],
) -> (Vec<f32>, Bins) {
    let (width, height) = (bins.width(), 2 * bins.s_max + 1);
    let along = coarser(bins.r_max, x);
    let across = coarser(bins.s_max, y);
    let pooled = Bins { r_max: along.max, s_max: across.max };
    let mut rows = vec![0.0_f32; pooled.width() * height * padded];
    for (from, to) in
        numbers.chunks_exact(width * padded).zip(rows.chunks_exact_mut(pooled.width() * padded))
    {
        for (cell, parts) in from.chunks_exact(padded).zip(&along.parts) {
            for (target, weight) in parts {
                let out = &mut to[target * padded..][..padded];
                out.iter_mut().zip(cell).for_each(|(out, number)| *out += weight * number);
            }
        }
    }
    let line = pooled.width() * padded;
    let mut out = vec![0.0_f32; line * (2 * pooled.s_max + 1)];
    for (from, parts) in rows.chunks_exact(line).zip(&across.parts) {
        for (target, weight) in parts {
            let to = &mut out[target * line..][..line];
            to.iter_mut().zip(from).for_each(|(out, number)| *out += weight * number);
        }
    }
    (out, pooled)
}

/// What the bins of an axis become.
struct Coarser {
    /// Largest bin of the coarser grid.
    max: usize,
    /// For each bin its targets with their weights.
    parts: Vec<Vec<(usize, f32)>>,
}

fn coarser(max: usize, factor: usize) -> Coarser {
    if factor == 1 {
        return Coarser { max, parts: (0..=2 * max).map(|bin| vec![(bin, 1.0)]).collect() };
    }
    let reach = REACH * POOL_SIGMA;
    let coarse = max.div_ceil(factor) + reach.ceil() as usize;
    let of = |bin: usize| {
        let place = (bin as f64 - max as f64) / factor as f64 + coarse as f64;
        let targets = (place - reach).ceil() as usize..=(place + reach).floor() as usize;
        let weight = |target: usize| {
            let away = (target as f64 - place) / POOL_SIGMA;
            (target, (-0.5 * away * away).exp() as f32)
        };
        targets.map(weight).collect()
    };
    Coarser { max: coarse, parts: (0..=2 * max).map(of).collect() }
}
