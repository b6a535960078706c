//! The windowed amplitude `P(f; z)` of a periodic patch and its mean square over window positions.
//!
//! Two independent ways compute it: straight from the definition (slow, obvious), and [`Field`], exact to 1e-9 of the
//! peak. Neither uses a term basis, so both can judge every basis.
//!
//! `P(f; z) = Σ_rs c_rs(z) ĝ(f - (r/Lx, s/Ly))`, `c_rs(z) = 1/(NM) Σ_xy exp(i z h) exp(2πi(r x/Lx + s y/Ly))`, origin at
//! the patch centre, `ĝ(f) = exp(-2π²σs²|f|²)` with peak 1 (Stam 1999, eqs. 9–13, with a Gaussian coherence window).
//! `ensemble` is `Σ_rs |c_rs(z)|² ĝ(f - f_rs)²`: by Parseval the mean of `|P|²` over all window positions.

pub mod transform;
pub mod replicas;
pub mod reference;
pub mod orders;
pub mod rigorous;
pub mod comparison_directions;

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use crate::field::transform::{Bins, GridAxis, axes, heights_upwards_um, ifft2};
use crate::plan::Coherence;
use crate::surface::HeightField;

/// Minimum weight of the window that is summed. The sum of `|c|²` is 1, so the amplitude's error is little more than this.
const MIN_WEIGHT: f64 = 1e-12;
/// Maximum error of the interpolation in `z`.
const NODE_ERROR: f64 = 1e-11;
/// Maximum size of a table, bytes.
const MAX_BYTES: usize = 6 << 30;
/// Maximum number of bins to either side of a frequency. With more, the window is split (see [`Field`]).
const MAX_BINS: f64 = 12.0;

/// `P(f; z)` straight from the definition. `f` is in cycles per µm, `z` in 1/µm, `sigma_um` is the window's standard deviation.
pub fn amplitude_brute(height: &HeightField, f: DVec2, z: f64, sigma_um: f64) -> Complex64 {
    brute_bins(height, f, sigma_um)
        .map(|(r, s, weight)| coefficient_brute(height, r, s, z) * weight)
        .sum()
}

/// `Σ |c_rs|² ĝ²` straight from the definition.
pub fn ensemble_brute(height: &HeightField, f: DVec2, z: f64, sigma_um: f64) -> f64 {
    brute_bins(height, f, sigma_um)
        .map(|(r, s, weight)| coefficient_brute(height, r, s, z).norm_sqr() * weight * weight)
        .sum()
}

/// `c_rs(z)` as the plain double sum over pixels.
pub fn coefficient_brute(height: &HeightField, r: i64, s: i64, z: f64) -> Complex64 {
    phase_sum(height, DVec2::new(r as f64 / height.size_x_um(), s as f64 / height.size_y_um()), z)
}

/// `1/(NM) Σ_xy exp(i z h) exp(2πi(fx x + fy y))` at any frequency, cycles per µm: the transform of one patch alone.
pub fn phase_sum(height: &HeightField, f: DVec2, z: f64) -> Complex64 {
    let [x, y] = axes(height);
    let heights_um = heights_upwards_um(height);
    let term = |(i, h): (usize, &f64)| {
        let place = DVec2::new(x.position_um(i % x.count), y.position_um(i / x.count));
        Complex64::cis(z * h + TAU * f.dot(place))
    };
    heights_um.iter().enumerate().map(term).sum::<Complex64>() / heights_um.len() as f64
}

fn brute_bins(
    height: &HeightField,
    f: DVec2,
    sigma_um: f64,
) -> impl Iterator<Item = (i64, i64, f64)> {
    let (lx, ly) = (height.size_x_um(), height.size_y_um());
    let reach_cpum = (-2.0 * 1e-18_f64.ln()).sqrt() / (TAU * sigma_um);
    let range = move |f: f64, l: f64| {
        ((f - reach_cpum) * l).floor() as i64..=((f + reach_cpum) * l).ceil() as i64
    };
    range(f.y, ly).flat_map(move |s| {
        range(f.x, lx).map(move |r| {
            let d = f - DVec2::new(r as f64 / lx, s as f64 / ly);
            (r, s, (-2.0 * (PI * sigma_um).powi(2) * d.length_squared()).exp())
        })
    })
}

/// The arguments that a [`Field`] must cover.
#[derive(Clone, Copy, Debug)]
pub struct Domain {
    /// Whether amplitudes or intensities of the orders add.
    pub coherence: Coherence,
    /// Minimum and maximum standard deviation of the window, µm.
    pub sigma_um: (f64, f64),
    /// Minimum and maximum `z = k·w`, 1/µm.
    pub z: (f64, f64),
    /// Maximum `|f|` on either axis, cycles per µm.
    pub reach_cpum: f64,
}

/// `|P(f; z)|²` (or its ensemble mean) of one surface, fast and exact to 1e-9.
///
/// * **In z**: `c_rs(z)` is entire in z, of exponential type half the height range, so it is interpolated from its
///   values at Chebyshev nodes; the number of nodes follows from the Jacobi–Anger tail. Each node is one transform of
///   `exp(i z h)` itself. The ensemble's `|c_rs|²` is interpolated likewise, at twice the type.
/// * **In f**: all bins whose weight counts. Where a short coherence length would need very many, the Gaussian is split
///   into a product, `1/σs² = 1/σ1² + 1/σ2²`. The first factor is applied in space to a tile just large enough for it,
///   which has fewer bins. The second factor remains as the sum over bins. In the ensemble the signal is the
///   autocorrelation of `exp(i z h)` under a window √2 wider.
///
/// Table: `[s][r][node]`, complex (`single`) or real (`ensemble`).
pub struct Field {
    coherence: Coherence,
    axes: [SplitAxis; 2],
    bins: Bins,
    nodes: Nodes,
    height_middle_um: f64,
    table: Vec<f64>,
}

/// One axis of the tile and the part of the window that was applied to it in space.
#[derive(Clone, Copy, Debug)]
struct SplitAxis {
    axis: GridAxis,
    /// Standard deviation of the factor applied in space, µm; infinite if no factor is.
    applied_um: f64,
}

impl SplitAxis {
    /// `sigma_um`: minimum and maximum standard deviation of the window on the signal.
    fn new(patch: GridAxis, origin_um: f64, sigma_um: (f64, f64)) -> SplitAxis {
        let whole = GridAxis { start_um: origin_um, ..patch };
        if cut_bins(patch.period_um, sigma_um.0) <= MAX_BINS {
            return SplitAxis { axis: whole, applied_um: f64::INFINITY };
        }
        let applied_um = std::f64::consts::SQRT_2 * sigma_um.1;
        let rest_um = remaining_um(sigma_um.1, applied_um);
        let pitch_um = patch.period_um / patch.count as f64;
        // images of the tile meet the window's product at exp(-L'²/2(σ1² + σ2²))
        let period_um = (-2.0 * MIN_WEIGHT.ln()).sqrt() * applied_um.hypot(rest_um);
        let count = (period_um / pitch_um).ceil() as usize;
        let first = ((-0.5 * count as f64 * pitch_um - origin_um) / pitch_um).round();
        let axis = GridAxis {
            count,
            start_um: origin_um + first * pitch_um,
            period_um: count as f64 * pitch_um,
        };
        SplitAxis { axis, applied_um }
    }

    /// Index of the patch sample that lies at sample `index` of the tile.
    fn patch_index(&self, index: usize, patch: GridAxis, origin_um: f64) -> usize {
        let pitch_um = patch.period_um / patch.count as f64;
        let first = ((self.axis.start_um - origin_um) / pitch_um).round() as i64;
        (first + index as i64).rem_euclid(patch.count as i64) as usize
    }

    fn applied_weight(&self, index: usize) -> f64 {
        let t = self.axis.position_um(index) / self.applied_um;
        (-0.5 * t * t).exp()
    }

    /// First bin and weights around `f`, for a window of `sigma_um` on the signal.
    fn weights(&self, f: f64, sigma_um: f64, max: usize, out: &mut Vec<f64>) -> usize {
        let rest_um = remaining_um(sigma_um, self.applied_um);
        let norm = if self.applied_um.is_infinite() { 1.0 } else { rest_um / sigma_um };
        let place = f * self.axis.period_um;
        let cut = cut_bins(self.axis.period_um, rest_um);
        let max = max as f64;
        let (first, last) = ((place - cut).ceil().max(-max), (place + cut).floor().min(max));
        let factor = TAU * rest_um / self.axis.period_um;
        out.clear();
        let mut bin = first;
        while bin <= last {
            let t = (place - bin) * factor;
            out.push(norm * (-0.5 * t * t).exp());
            bin += 1.0;
        }
        if out.is_empty() { 0 } else { (first + max) as usize }
    }
}

/// Number of bins to either side at which a window of `sigma_um` falls to [`MIN_WEIGHT`].
fn cut_bins(period_um: f64, sigma_um: f64) -> f64 {
    (-2.0 * MIN_WEIGHT.ln()).sqrt() * period_um / (TAU * sigma_um)
}

/// `σ2` of `1/σ² = 1/σ1² + 1/σ2²`.
fn remaining_um(sigma_um: f64, applied_um: f64) -> f64 {
    1.0 / (1.0 / (sigma_um * sigma_um) - 1.0 / (applied_um * applied_um)).sqrt()
}

/// Sizes that follow from a domain, before any work is done.
struct Layout {
    nodes: Nodes,
    split: [SplitAxis; 2],
    bins: Bins,
    parts: usize,
    height_middle_um: f64,
}

impl Layout {
    fn new(height: &HeightField, domain: &Domain) -> Layout {
        let (low_um, high_um) = height.range_um();
        let (widen, parts, half_type_um) = match domain.coherence {
            Coherence::Single => (1.0, 2, 0.5 * (high_um - low_um)),
            Coherence::Ensemble => (std::f64::consts::SQRT_2, 1, high_um - low_um),
        };
        let sigma_um = (widen * domain.sigma_um.0, widen * domain.sigma_um.1);
        let split =
            axes(height).map(|p| SplitAxis::new(p, origin_um(domain.coherence, p), sigma_um));
        let reach = |s: &SplitAxis| {
            let cut = cut_bins(s.axis.period_um, remaining_um(sigma_um.0, s.applied_um));
            (domain.reach_cpum * s.axis.period_um + cut).ceil() as usize + 1
        };
        Layout {
            nodes: Nodes::new(domain.z, half_type_um),
            split,
            bins: Bins { r_max: reach(&split[0]), s_max: reach(&split[1]) },
            parts,
            height_middle_um: 0.5 * (low_um + high_um),
        }
    }

    fn stride(&self) -> usize {
        self.parts * self.nodes.z.len()
    }
}

/// Position of sample 0 of the transformed signal: pixel 0 of the patch, or lag 0 of its autocorrelation.
fn origin_um(coherence: Coherence, patch: GridAxis) -> f64 {
    match coherence {
        Coherence::Single => patch.start_um,
        Coherence::Ensemble => 0.0,
    }
}

impl Field {
    /// Transforms `exp(i z h)` at every node. Time: one two-dimensional transform per node.
    pub fn new(height: &HeightField, domain: &Domain) -> Field {
        let layout = Layout::new(height, domain);
        let stride = layout.stride();
        let Layout { nodes, split, bins, parts, height_middle_um } = layout;
        let patch = axes(height);
        let coherence = domain.coherence;
        // an ensemble's |c_rs|² comes straight from the bins, or from the autocorrelation where the window is split
        let tiled = split.iter().any(|s| s.applied_um.is_finite());
        let heights_um: Vec<f64> =
            heights_upwards_um(height).iter().map(|h| h - height_middle_um).collect();
        let mut table = vec![0.0; bins.len() * stride];
        for (n, &z) in nodes.z.iter().enumerate() {
            let mut signal: Vec<Complex64> =
                heights_um.par_iter().map(|h| Complex64::cis(z * h)).collect();
            if tiled {
                if coherence == Coherence::Ensemble {
                    signal = autocorrelation(signal, patch);
                }
                signal = tile(&signal, patch, split, coherence);
            }
            let coefficients = ifft2(&mut signal, split.map(|s| s.axis), bins);
            table.par_chunks_mut(stride).zip(&coefficients).for_each(|(cell, c)| match coherence {
                Coherence::Single => (cell[parts * n], cell[parts * n + 1]) = (c.re, c.im),
                Coherence::Ensemble => cell[n] = if tiled { c.re } else { c.norm_sqr() },
            });
        }
        Field { coherence, axes: split, bins, nodes, height_middle_um, table }
    }

    /// Bytes of the table that [`Field::new`] would allocate.
    pub fn bytes_needed(height: &HeightField, domain: &Domain) -> usize {
        let layout = Layout::new(height, domain);
        layout.bins.len().saturating_mul(layout.stride()).saturating_mul(size_of::<f64>())
    }

    /// Bytes that [`Field::new`] takes at most, beside the heights: an estimate.
    pub fn working_bytes(height: &HeightField, domain: &Domain) -> u64 {
        const COMPLEX: usize = size_of::<Complex64>();
        let layout = Layout::new(height, domain);
        let pixels = height.heights_um().len();
        let (signal, bins) = (COMPLEX * pixels, COMPLEX.saturating_mul(layout.bins.len()));
        let table = layout.bins.len().saturating_mul(layout.stride() * size_of::<f64>());
        let is_tiled = layout.split.iter().any(|s| s.applied_um.is_finite());
        let tile: usize = layout.split.iter().map(|s| s.axis.count).product();
        // a transform has its samples, their columns, and the bins in order
        let node = match (is_tiled, domain.coherence) {
            (false, _) => signal.saturating_add(2 * bins),
            (true, coherence) => {
                // the autocorrelation transposes, which takes a second signal
                let doubled = if coherence == Coherence::Ensemble { 2 * signal } else { 0 };
                doubled.max(signal + COMPLEX * tile).max(COMPLEX * tile + 2 * bins)
            }
        };
        height.byte_count().saturating_add(table as u64).saturating_add(node as u64)
    }

    /// Number of transforms that were computed.
    pub fn node_count(&self) -> usize {
        self.nodes.z.len()
    }

    /// Bytes of the table.
    pub fn table_bytes(&self) -> usize {
        self.table.len() * size_of::<f64>()
    }

    /// `|P(f; z)|²`, or its ensemble mean. `f` is in cycles per µm, within the domain's reach; `sigma_um` is the
    /// window's standard deviation.
    pub fn intensity(&self, f: DVec2, z: f64, sigma_um: f64, scratch: &mut Scratch) -> f64 {
        match self.coherence {
            Coherence::Single => self.sum(f, z, sigma_um, scratch).norm_sqr(),
            Coherence::Ensemble => self.sum(f, z, std::f64::consts::SQRT_2 * sigma_um, scratch).re,
        }
    }

    /// `P(f; z)` itself, phase included. `None` for an ensemble, which has no phase.
    pub fn amplitude(
        &self,
        f: DVec2,
        z: f64,
        sigma_um: f64,
        scratch: &mut Scratch,
    ) -> Option<Complex64> {
        (self.coherence == Coherence::Single)
            .then(|| self.sum(f, z, sigma_um, scratch) * Complex64::cis(z * self.height_middle_um))
    }

    fn sum(&self, f: DVec2, z: f64, sigma_um: f64, scratch: &mut Scratch) -> Complex64 {
        let Scratch { x: weights_x, y: weights_y, sums } = scratch;
        let first_r = self.axes[0].weights(f.x, sigma_um, self.bins.r_max, weights_x);
        let first_s = self.axes[1].weights(f.y, sigma_um, self.bins.s_max, weights_y);
        if weights_x.is_empty() || weights_y.is_empty() {
            return Complex64::default();
        }
        let stride = self.table.len() / self.bins.len();
        sums.clear();
        sums.resize(stride, 0.0);
        for (j, wy) in weights_y.iter().enumerate() {
            let start = ((first_s + j) * self.bins.width() + first_r) * stride;
            let row = &self.table[start..start + weights_x.len() * stride];
            for (cell, wx) in row.chunks_exact(stride).zip(weights_x.iter()) {
                let weight = wx * wy;
                for (sum, value) in sums.iter_mut().zip(cell) {
                    *sum += weight * value;
                }
            }
        }
        self.nodes.interpolate(z, sums)
    }
}

/// Buffers of [`Field::intensity`], one per thread.
#[derive(Default)]
pub struct Scratch {
    x: Vec<f64>,
    y: Vec<f64>,
    sums: Vec<f64>,
}

/// The periodic samples on the tile, multiplied by the factor of the window that is applied in space.
fn tile(
    signal: &[Complex64],
    patch: [GridAxis; 2],
    split: [SplitAxis; 2],
    coherence: Coherence,
) -> Vec<Complex64> {
    let column: Vec<(usize, f64)> = (0..split[0].axis.count)
        .map(|i| {
            (
                split[0].patch_index(i, patch[0], origin_um(coherence, patch[0])),
                split[0].applied_weight(i),
            )
        })
        .collect();
    let row = |j: usize| {
        let start =
            split[1].patch_index(j, patch[1], origin_um(coherence, patch[1])) * patch[0].count;
        let weight = split[1].applied_weight(j);
        column.iter().map(move |&(i, wx)| signal[start + i] * (wx * weight))
    };
    (0..split[1].axis.count).flat_map(row).collect()
}

/// `1/(NM) Σ p(x) p*(x + lag)` at all lags, lag 0 first: the signal whose transform is `|c_rs|²`.
fn autocorrelation(mut signal: Vec<Complex64>, patch: [GridAxis; 2]) -> Vec<Complex64> {
    // every bin once, in the order of the transform, then back: both directions by the same routine, since |c|² is real
    let mut planner = rustfft::FftPlanner::new();
    let mut both = |data: &mut Vec<Complex64>| {
        for axis in patch {
            let plan = planner.plan_fft_inverse(axis.count);
            data.par_chunks_mut(axis.count).for_each(|line| plan.process(line));
            *data = transpose(data, axis.count);
        }
    };
    let scale = 1.0 / signal.len() as f64;
    both(&mut signal);
    for value in &mut signal {
        *value = Complex64::new((*value * scale).norm_sqr(), 0.0);
    }
    both(&mut signal);
    signal.iter_mut().for_each(|v| *v = v.conj());
    signal
}

fn transpose(data: &[Complex64], width: usize) -> Vec<Complex64> {
    let height = data.len() / width;
    (0..width).flat_map(|x| (0..height).map(move |y| data[y * width + x])).collect()
}

/// Chebyshev nodes of the first kind and barycentric interpolation (Berrut & Trefethen 2004, eq. 5.3).
struct Nodes {
    z: Vec<f64>,
    weight: Vec<f64>,
}

impl Nodes {
    /// Enough nodes in `z` to interpolate `exp(i z t)`, `|t| <= half_type_um`, within [`NODE_ERROR`].
    fn new((low, high): (f64, f64), half_type_um: f64) -> Nodes {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let count = node_count(half * half_type_um);
        let angle = |k: usize| PI * (2 * k + 1) as f64 / (2 * count) as f64;
        let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        Nodes {
            z: (0..count).map(|k| middle + half * angle(k).cos()).collect(),
            weight: (0..count).map(|k| sign(k) * angle(k).sin()).collect(),
        }
    }

    /// `values`: one (real) or two (complex, interleaved) numbers per node.
    fn interpolate(&self, z: f64, values: &[f64]) -> Complex64 {
        let complex = values.len() == 2 * self.z.len();
        let value = |n: usize| {
            if complex {
                Complex64::new(values[2 * n], values[2 * n + 1])
            } else {
                Complex64::new(values[n], 0.0)
            }
        };
        if self.z.len() == 1 {
            return value(0);
        }
        let (mut numerator, mut denominator) = (Complex64::default(), 0.0);
        for (n, (node, weight)) in self.z.iter().zip(&self.weight).enumerate() {
            let distance = z - node;
            if distance == 0.0 {
                return value(n);
            }
            let w = weight / distance;
            numerator += value(n) * w;
            denominator += w;
        }
        numerator / denominator
    }
}

/// Smallest `n` with `4 Σ_{k≥n} |J_k(a)|` within [`NODE_ERROR`]: the tail of the Jacobi–Anger series, aliased once.
fn node_count(a: f64) -> usize {
    let a = a.abs();
    let mut count = a.ceil() as usize + 64;
    let mut tail = 0.0;
    while count > 1 {
        tail += 4.0 * libm::jn(count as i32 - 1, a).abs();
        if tail > NODE_ERROR {
            return count;
        }
        count -= 1;
    }
    1
}
