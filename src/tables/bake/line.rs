//! Amplitudes on lines through the origin of the frequency plane, and their colours.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use crate::field::transform::Bins;
use crate::optics::spectrum::Spectrum;
use crate::optics::{self, Facing, Matter};
use crate::plan::{Basis, Coherence, CoherenceScaling, Wavelengths, Window};
use crate::surface::HeightField;
use crate::tables::BakedAxes;
use crate::tables::bake::Light;
use crate::tables::basis::Expansion;
use crate::tables::terms::Terms;

use super::pool;

/// Number of columns that are computed together: they fill one or a few vector registers.
pub(super) const LANES: usize = 16;
/// Number of a bin's numbers that are summed together.
const CHUNK: usize = 8;
/// The window's spectrum is cut at this many standard deviations, where it is 4e-5 of the peak.
const REACH_SIGMAS: f64 = 4.5;
/// Step along a line in standard deviations `σf`. `|P|²` is a sum of Gaussians no narrower than `σf/√2`, which this
/// step integrates to 1e-8.
const STEP_SIGMAS: f64 = 0.7;
/// Minimum number of wavelengths of a row. The colour weights need them: they are 5 nm apart.
const MIN_NODES: f64 = 80.0;
/// Maximum error of the phase function with the terms used.
const TERM_ERROR: f64 = 1e-3;

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub(super) struct RadiusRow {
    pub(super) radius: f64,
}

/// The nodes that a row uses from a line, at frequencies `(first + i)·step`, with their weights.
struct Recipe {
    /// Number of halvings of the line's step. Rows with the same number share a line.
    halvings: u32,
    /// First node, in steps.
    first: usize,
    /// Wavelengths, µm.
    lambdas_um: Vec<f64>,
    /// X, Y, Z of every node.
    colours: Vec<[f32; 3]>,
    /// Coefficients `[node][level][feature]`.
    coefficients: Vec<f32>,
}

/// Sizes that are known before the work begins.
struct Sizes {
    expansion: Expansion,
    bins: Bins,
    /// The narrowest window, cycles per µm.
    narrowest_cpum: f64,
    step_cpum: f64,
    /// Minimum number of wavelengths of a row.
    min_nodes: f64,
    /// Numbers of a bin, and their count in whole chunks.
    features: usize,
    padded: usize,
}

impl Sizes {
    fn new(height: &HeightField, light: Light<'_>, axes: &BakedAxes) -> Sizes {
        let Light { window, range, matter, .. } = light;
        let range_nm = [range.min_nm, range.max_nm];
        let phase_min_nm = matter.map_or(range.min_nm, |matter| matter.phase_min_nm(range_nm));
        let least_z = matter.map_or(0.0, |matter| matter.least_z(range_nm));
        let expansion =
            Expansion::over((least_z, phase_min_nm), phase_min_nm, Basis::Optimal, 1, height)
                .with_error(TERM_ERROR);
        let film_um = matter.map_or(0.0, |matter| matter.detail_um(0.0));
        // eight nodes for each period of the interference in the films
        let periods = 2.0 * film_um * (1e3 / range.min_nm - 1e3 / range.max_nm);
        let min_nodes = MIN_NODES.max(8.0 * periods);
        let sigma = |nm: f64| 1.0 / (TAU * optics::window_sigma_um(window, nm));
        let sigmas = [sigma(range.min_nm), sigma(range.max_nm)];
        let narrowest = sigmas[0].min(sigmas[1]);
        let widest = sigmas[0].max(sigmas[1]);
        let reach = axes.radius(axes.rows - 1) / (range.min_nm * 1e-3) + REACH_SIGMAS * widest;
        let bins = Bins::reachable(height.size_x_um(), height.size_y_um(), reach, 2);
        let count = expansion.terms as usize;
        let features = match window.coherence {
            Coherence::Single => 2 * count,
            Coherence::Ensemble => count * (count + 1) / 2,
        };
        let padded = features.next_multiple_of(CHUNK);
        let step_cpum = STEP_SIGMAS * narrowest;
        Sizes { expansion, bins, narrowest_cpum: narrowest, step_cpum, min_nodes, features, padded }
    }
}

/// Bytes that [`Lines`] takes while it is made, and then as long as it lives, with the lines of `threads` threads.
pub(super) fn bytes(
    height: &HeightField,
    light: Light<'_>,
    axes: &BakedAxes,
    threads: usize,
) -> [u64; 2] {
    let Light { window, range, .. } = light;
    let sizes = Sizes::new(height, light, axes);
    let numbers = size_of::<f32>() * sizes.padded * sizes.bins.len();
    let complex = size_of::<rustfft::num_complex::Complex64>();
    let terms = complex * sizes.expansion.terms as usize * sizes.bins.len();
    let per_level = match window.coherence {
        Coherence::Single => sizes.features / 2,
        Coherence::Ensemble => sizes.features,
    };
    let places = |row: RadiusRow| {
        let Pace { first, last, .. } = Pace::new(row, range, sizes.step_cpum, sizes.min_nodes);
        last + 1 - first.min(last)
    };
    let nodes: usize = super::rows(axes).map(places).sum();
    let coefficients = size_of::<f32>() * nodes * axes.levels as usize * per_level;
    let longest = axes.radius(axes.rows - 1) / (range.min_nm * 1e-3) / sizes.step_cpum;
    let line = size_of::<[f32; LANES]>() * longest as usize * sizes.padded;
    let transforms = Terms::working_bytes(height, &sizes.expansion, sizes.bins, None);
    let kept = (numbers + coefficients + threads * line) as u64;
    [terms as u64 + transforms.max(numbers as u64), kept]
}

/// Everything that all columns share.
pub(super) struct Lines {
    axes: BakedAxes,
    recipes: Vec<Recipe>,
    step_cpum: f64,
    /// `[s][r][number]`, padded to whole chunks.
    bins: Bins,
    numbers: Vec<f32>,
    features: usize,
    padded: usize,
    coherence: Coherence,
    patch_um: [f64; 2],
    window: Window,
    /// Number of bins along x and y that were pooled.
    pooled: [usize; 2],
}

impl Lines {
    pub(super) fn new(
        height: &HeightField,
        light: Light<'_>,
        spectrum: &Spectrum,
        axes: BakedAxes,
    ) -> Lines {
        let Light { window, range, matter, pooled } = light;
        let sizes = Sizes::new(height, light, &axes);
        let narrowest_cpum = sizes.narrowest_cpum;
        let Sizes { expansion, bins, step_cpum, min_nodes, features, padded, .. } = sizes;
        let patch_um = [height.size_x_um(), height.size_y_um()];
        let terms = Terms::new(height, &expansion, bins, None);
        let mut numbers = numbers(&terms, window.coherence, padded);
        drop(terms);
        let mut bins = bins;
        let factors = match (pooled, window.coherence) {
            (true, Coherence::Ensemble) => {
                patch_um.map(|size_um| pool::factor(narrowest_cpum * FRAC_1_SQRT_2 * size_um))
            }
            _ => [1; 2],
        };
        if factors != [1; 2] {
            (numbers, bins) = pool::pool(&numbers, bins, padded, factors);
        }
        let recipe = |row: RadiusRow| {
            let pace = Pace::new(row, range, step_cpum, min_nodes);
            let mut recipe = Recipe::nodes(pace, spectrum);
            recipe.combine(row, &axes, &expansion, window.coherence, range, matter);
            recipe
        };
        let recipes = super::rows(&axes).map(recipe).collect();
        Lines {
            axes,
            recipes,
            step_cpum,
            bins,
            numbers,
            features,
            padded,
            coherence: window.coherence,
            patch_um,
            window,
            pooled: factors,
        }
    }

    /// Colours of [`LANES`] columns from `first` on, `[row][level][X, Y, Z][lane]`.
    pub(super) fn block(&self, first: u32) -> Vec<[[f32; LANES]; 3]> {
        let levels = self.axes.levels as usize;
        let directions: [[f64; 2]; LANES] = std::array::from_fn(|lane| {
            self.axes.direction((first + lane as u32) % self.axes.columns)
        });
        let mut out = vec![[[0.0; LANES]; 3]; self.recipes.len() * levels];
        let mut line = Line::default();
        // steps grow with the distance from the mirror direction
        let fixed = self.window.coherence_scaling == CoherenceScaling::Fixed;
        let mut rest = self.recipes.as_slice();
        let mut out_rest = out.as_mut_slice();
        while let Some(head) = rest.first() {
            let same = |r: &&Recipe| fixed && r.halvings == head.halvings;
            let count = rest.iter().take_while(same).count().max(1);
            let (group, others) = rest.split_at(count);
            let (cells, out_others) = out_rest.split_at_mut(count * levels);
            self.walk(group, &directions, &mut line);
            for (recipe, cells) in group.iter().zip(cells.chunks_mut(levels)) {
                self.integrate(recipe, &line, cells);
            }
            (rest, out_rest) = (others, out_others);
        }
        out
    }

    /// The line that a group of rows needs, for all lanes.
    fn walk(&self, group: &[Recipe], directions: &[[f64; 2]; LANES], line: &mut Line) {
        let first = group.iter().map(|r| r.first).min().unwrap_or(0);
        let last = group.iter().map(|r| r.first + r.lambdas_um.len()).max().unwrap_or(0);
        line.first = first;
        line.values.clear();
        line.values.resize((last - first) * self.padded, [0.0; LANES]);
        let step = group.first().map_or(0.0, |r| r.step(self.step_cpum));
        let fixed = optics::window_sigma_um(self.window, optics::REFERENCE_NM);
        let mut taps = Taps::default();
        for (lane, direction) in directions.iter().enumerate() {
            for (index, cell) in line.values.chunks_exact_mut(self.padded).enumerate() {
                let f = (first + index) as f64 * step;
                let sigma_um = match (self.window.coherence_scaling, group) {
                    (CoherenceScaling::Wavelength, [one]) => {
                        optics::window_sigma_um(self.window, 1e3 * one.lambdas_um[index])
                    }
                    _ => fixed,
                };
                taps.around(self, direction.map(|c| c * f), sigma_um);
                taps.sum(self, lane, cell);
            }
        }
    }

    /// Sums a row: |P|² of every node and level, times its colour.
    fn integrate(&self, recipe: &Recipe, line: &Line, out: &mut [[[f32; LANES]; 3]]) {
        let levels = self.axes.levels as usize;
        let per_level = self.coefficients();
        let offset = recipe.first - line.first;
        for (node, xyz) in recipe.colours.iter().enumerate() {
            let values = &line.values[(offset + node) * self.padded..][..self.features];
            let all = &recipe.coefficients[node * levels * per_level..][..levels * per_level];
            for (own, out) in all.chunks_exact(per_level).zip(out.iter_mut()) {
                let intensity = match self.coherence {
                    Coherence::Single => modulus(own, values),
                    Coherence::Ensemble => linear(own, values),
                };
                for (out, weight) in out.iter_mut().zip(xyz) {
                    for (out, intensity) in out.iter_mut().zip(&intensity) {
                        *out += weight * intensity;
                    }
                }
            }
        }
    }

    /// Number of coefficients of a level.
    fn coefficients(&self) -> usize {
        match self.coherence {
            Coherence::Single => self.features / 2,
            Coherence::Ensemble => self.features,
        }
    }
}

/// `|Σ a_n P_n|²`, `values` as pairs of real and imaginary parts.
fn modulus(coefficients: &[f32], values: &[[f32; LANES]]) -> [f32; LANES] {
    let mut re = [0.0; LANES];
    let mut im = [0.0; LANES];
    for (a, pair) in coefficients.iter().zip(values.chunks_exact(2)) {
        for lane in 0..LANES {
            re[lane] += a * pair[0][lane];
            im[lane] += a * pair[1][lane];
        }
    }
    std::array::from_fn(|lane| re[lane] * re[lane] + im[lane] * im[lane])
}

/// `Σ a_k Q_k`.
fn linear(coefficients: &[f32], values: &[[f32; LANES]]) -> [f32; LANES] {
    let mut sum = [0.0; LANES];
    for (a, value) in coefficients.iter().zip(values) {
        for lane in 0..LANES {
            sum[lane] += a * value[lane];
        }
    }
    sum
}

/// Numbers of every bin. For `single`: real and imaginary part of every term. For `ensemble`: the real parts of all
/// products `c_n c_m*`, `n ≤ m`, doubled for `n ≠ m`.
fn numbers(terms: &Terms, coherence: Coherence, padded: usize) -> Vec<f32> {
    let count = terms.tables.len();
    let mut numbers = vec![0.0; terms.bins.len() * padded];
    for (bin, cell) in numbers.chunks_exact_mut(padded).enumerate() {
        match coherence {
            Coherence::Single => {
                for (table, pair) in terms.tables.iter().zip(cell.chunks_exact_mut(2)) {
                    (pair[0], pair[1]) = (table[bin].re as f32, table[bin].im as f32);
                }
            }
            Coherence::Ensemble => {
                let pairs = (0..count).flat_map(|n| (n..count).map(move |m| (n, m)));
                for ((n, m), out) in pairs.zip(cell) {
                    let product = (terms.tables[n][bin] * terms.tables[m][bin].conj()).re;
                    *out = (if n == m { product } else { 2.0 * product }) as f32;
                }
            }
        }
    }
    numbers
}

/// The nodes of a row along the wavenumber 1/λ.
struct Pace {
    /// Ends of the range, 1/µm.
    ends: [f64; 2],
    halvings: u32,
    point: bool,
    pace: f64,
    first: usize,
    last: usize,
}

impl Pace {
    fn new(row: RadiusRow, range: &Wavelengths, step_cpum: f64, min_nodes: f64) -> Pace {
        let ends = [1e3 / range.max_nm, 1e3 / range.min_nm];
        let span = ends[1] - ends[0];
        let steps = |halvings: u32| row.radius * span / step_cpum * f64::from(1_u32 << halvings);
        let halvings = (0..MAX_HALVINGS).find(|&h| steps(h) >= min_nodes);
        let halvings = halvings.unwrap_or(MAX_HALVINGS);
        let point = halvings == MAX_HALVINGS;
        // in wavenumbers 1/λ
        let pace = match point {
            true => span / min_nodes,
            false => step_cpum / f64::from(1_u32 << halvings) / row.radius,
        };
        let first = (ends[0] / pace).ceil() as usize;
        let last = (ends[1] / pace).floor() as usize;
        Pace { ends, halvings, point, pace, first, last }
    }
}

impl Recipe {
    /// The wavelengths of a row and their colours.
    fn nodes(pace: Pace, spectrum: &Spectrum) -> Recipe {
        let Pace { ends, halvings, point, pace, first, last } = pace;
        let mut recipe = Recipe {
            halvings,
            first: if point { 0 } else { first },
            lambdas_um: Vec::new(),
            colours: Vec::new(),
            coefficients: Vec::new(),
        };
        for node in first..=last {
            let wavenumber = node as f64 * pace;
            let lambda_um = 1.0 / wavenumber;
            // the trapezoidal rule, and at both ends the rest of the range
            let mut width = if node == first { 0.5 + (wavenumber - ends[0]) / pace } else { 0.5 };
            width += if node == last { (ends[1] - wavenumber) / pace } else { 0.5 };
            let weight = 1e3 * lambda_um * lambda_um * pace * width;
            recipe.lambdas_um.push(lambda_um);
            recipe.colours.push(spectrum.per_nm(1e3 * lambda_um).map(|c| (c * weight) as f32));
        }
        recipe
    }

    /// The coefficients of every node and level.
    fn combine(
        &mut self,
        row: RadiusRow,
        axes: &BakedAxes,
        expansion: &Expansion,
        coherence: Coherence,
        range: &Wavelengths,
        matter: Option<&Matter>,
    ) {
        let range_nm = [range.min_nm, range.max_nm];
        let min_um = matter.map_or(range.min_nm, |matter| matter.phase_min_nm(range_nm)) * 1e-3;
        let count = expansion.terms as usize;
        for lambda_um in &self.lambdas_um {
            for level in 0..axes.levels {
                let w = axes.w(level, row.radius);
                let (mut here, mut share) = (w, 1.0);
                if let Some(matter) = matter {
                    let lambda_nm = 1e3 * lambda_um;
                    here = matter.dispersed(w, lambda_nm);
                    let cos_half = 0.5 * row.radius.hypot(w) / matter.cover_index();
                    let s_share = matter.s_share().unwrap_or(0.5);
                    let ratio = matter.ratio(lambda_nm, Facing { cos_half, s_share });
                    // amplitudes are squared, intensities are products of two
                    share = ratio.sqrt();
                }
                let tau = 0.5 * here * min_um / lambda_um;
                let amplitude = |n| share * expansion.coefficient(n, tau);
                let a: Vec<f64> = (0..count).map(amplitude).collect();
                match coherence {
                    Coherence::Single => self.coefficients.extend(a.iter().map(|a| *a as f32)),
                    Coherence::Ensemble => {
                        let pairs = (0..count).flat_map(|n| (n..count).map(move |m| (n, m)));
                        self.coefficients.extend(pairs.map(|(n, m)| (a[n] * a[m]) as f32));
                    }
                }
            }
        }
    }

    fn is_point(&self) -> bool {
        self.halvings == MAX_HALVINGS
    }

    fn step(&self, step_cpum: f64) -> f64 {
        if self.is_point() { 0.0 } else { step_cpum / f64::from(1_u32 << self.halvings) }
    }
}

/// Maximum number of halvings of the step. A row that would need more is the mirror direction itself.
const MAX_HALVINGS: u32 = 16;

/// A section of the line of every lane, `[place][number][lane]`.
#[derive(Default)]
struct Line {
    first: usize,
    values: Vec<[f32; LANES]>,
}

/// Weights of the bins around a place.
#[derive(Default)]
struct Taps {
    first: [i64; 2],
    weights: [Vec<f32>; 2],
}

impl Taps {
    fn around(&mut self, lines: &Lines, f: [f64; 2], sigma_um: f64) {
        let max = [lines.bins.r_max as i64, lines.bins.s_max as i64];
        for axis in 0..2 {
            let size_um = lines.patch_um[axis] / lines.pooled[axis] as f64;
            let sigma_bins = size_um / (TAU * sigma_um);
            // an ensemble adds intensities, weighted by the squared window
            let mut squares = match lines.coherence {
                Coherence::Single => 0.5,
                Coherence::Ensemble => 1.0,
            } / (sigma_bins * sigma_bins);
            let mut reach = REACH_SIGMAS * sigma_bins;
            let mut whole = 1.0;
            if lines.pooled[axis] > 1 {
                let (rest, weight) = pool::remaining(0.5 / squares);
                (squares, whole) = (0.5 / rest, weight);
                reach = REACH_SIGMAS * rest.sqrt();
            }
            let place = f[axis] * size_um;
            let first = ((place - reach).ceil() as i64).max(-max[axis]);
            let last = ((place + reach).floor() as i64).min(max[axis]);
            let distance = place - first as f64;
            let weights = &mut self.weights[axis];
            weights.clear();
            // for a Gaussian at equal steps, the ratios of neighbours form a geometric sequence
            let mut weight = whole * (-squares * distance * distance).exp();
            let mut ratio = (squares * (2.0 * distance - 1.0)).exp();
            let bend = (-2.0 * squares).exp();
            for _ in first..=last {
                weights.push(weight as f32);
                weight *= ratio;
                ratio *= bend;
            }
            self.first[axis] = first + max[axis];
        }
    }

    fn sum(&self, lines: &Lines, lane: usize, out: &mut [[f32; LANES]]) {
        let [columns, rows] = &self.weights;
        let (width, padded) = (lines.bins.width(), lines.padded);
        for (chunk, out) in out.chunks_exact_mut(CHUNK).enumerate() {
            let mut sum = [0.0_f32; CHUNK];
            for (s, across) in rows.iter().enumerate() {
                let start = (self.first[1] as usize + s) * width + self.first[0] as usize;
                let mut at = start * padded + chunk * CHUNK;
                for along in columns {
                    let weight = across * along;
                    let cell = &lines.numbers[at..at + CHUNK];
                    for (sum, number) in sum.iter_mut().zip(cell) {
                        *sum += weight * number;
                    }
                    at += padded;
                }
            }
            for (out, sum) in out.iter_mut().zip(sum) {
                out[lane] = sum;
            }
        }
    }
}
