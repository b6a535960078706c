//! The colours of lobes for sums over lobes: integrals of the colour weights under a Gaussian of wavenumbers.

use std::f64::consts::{PI, SQRT_2};

use rayon::prelude::*;

use crate::optics::spectrum::Sample;

use super::corridor::{BROADEST, LobeGeometry, REACH_SIGMAS};
use super::{Settings, Table, lobe_table};

/// Number of nodes of the midpoint rule over a lobe, which is cut to the range. Over a whole lobe of 4√2 standard
/// deviations the rule is exact to 1e-9.
const STEPS: u32 = 64;

/// The spectrum table. `samples` are the colour weights per 1/µm, at equal steps of the wavenumber over the range.
pub fn lobes_table(
    samples: &[Sample],
    lobes: &LobeGeometry,
    count: u32,
    [columns, rows]: [u32; 2],
    settings: Settings,
) -> Table {
    let weights = Weights { samples, lobes };
    let pace = lobes.pace(count);
    let broad = |node: u32| {
        let bell = |t: f64, other: u32| (-((t - lobes.node(other, count)) / pace).powi(2)).exp();
        // the kernels of all nodes add up to 1 at every wavenumber
        let kernel = |t: f64| bell(t, node) / (0..count).map(|other| bell(t, other)).sum::<f64>();
        let middle = lobes.node(node, count);
        let reach = REACH_SIGMAS * pace;
        // at the node itself: the kernels reproduce linear functions of the wavenumber, for every colour
        let Moments { xyz: [x, y, z], .. } =
            weights.integral([middle - reach, middle + reach], kernel);
        [x, y, z, 1.0 / middle.clamp(lobes.range[0], lobes.range[1])]
    };
    let nodes = (0..count).into_par_iter().map(broad).collect();
    let [low, high] = lobes.middles(count);
    let place = |i: u32, count: u32| f64::from(i) / f64::from(count - 1);
    let cells = 0..rows * columns;
    let narrow = |cell: u32| {
        let (row, column) = (cell / columns, cell % columns);
        let middle = low + (high - low) * place(column, columns);
        let moments = weights.narrow(middle, place(row, rows) * BROADEST * pace);
        if LobeGeometry::is_halved(row, rows) { moments.halves() } else { moments.whole() }
    };
    let (mut narrow, second): (Vec<[f64; 4]>, Vec<[f64; 4]>) =
        cells.into_par_iter().map(narrow).collect();
    narrow.extend(second);
    lobe_table(nodes, narrow, columns as usize, settings)
}

struct Weights<'a> {
    samples: &'a [Sample],
    lobes: &'a LobeGeometry,
}

impl Weights<'_> {
    /// A narrow lobe. `width` is its width at the long-wavelength end of the range, `σf/|(u, v)|` in 1/µm.
    fn narrow(&self, middle: f64, width: f64) -> Moments {
        let LobeGeometry { range: [low, high], scales, .. } = *self.lobes;
        if width == 0.0 {
            let xyz = self.at(middle).map(|c| c * PI.sqrt() * if scales { middle } else { 1.0 });
            return Moments { xyz, shift: [0.0; 3], mean: middle.clamp(low, high), deviation: 0.0 };
        }
        let reach = REACH_SIGMAS / SQRT_2;
        let (span, over) = if scales {
            // a Gaussian in λ
            let share = reach * width / low;
            ([middle / (1.0 + share), middle / (1.0 - share).max(1e-3)], low / width)
        } else {
            ([middle - reach * width, middle + reach * width], 1.0 / width)
        };
        let lobe = |t: f64| {
            let offset = if scales { (middle / t - 1.0) * low } else { t - middle };
            over * (-(offset / width).powi(2)).exp()
        };
        self.integral(span, lobe)
    }

    /// Moments of the light under a kernel between two wavenumbers.
    fn integral(&self, [from, to]: [f64; 2], kernel: impl Fn(f64) -> f64) -> Moments {
        let [low, high] = self.lobes.range;
        let (from, to) = (from.max(low), to.min(high));
        let step = (to - from).max(0.0) / f64::from(STEPS);
        let nodes = (0..STEPS).map(|i| {
            let t = from + (f64::from(i) + 0.5) * step;
            (t, self.at(t).map(|c| c * step * kernel(t)))
        });
        let (mut xyz, mut total, mut first) = ([0.0; 3], 0.0, 0.0);
        for (t, part) in nodes.clone() {
            let light: f64 = part.iter().sum();
            xyz = std::array::from_fn(|c| xyz[c] + part[c]);
            total += light;
            first += t * light;
        }
        let mean = if total > 0.0 { first / total } else { 0.5 * (from + to) };
        let (mut shift, mut second) = ([0.0; 3], 0.0);
        for (t, part) in nodes {
            shift = std::array::from_fn(|c| shift[c] + (t - mean) * part[c]);
            second += (t - mean).powi(2) * part.iter().sum::<f64>();
        }
        let deviation = if total > 0.0 { (second / total).sqrt() } else { 0.0 };
        Moments { xyz, shift, mean: mean.clamp(low, high), deviation }
    }

    /// The weights at a wavenumber: linear between samples, zero outside.
    fn at(&self, t: f64) -> [f64; 3] {
        let [low, high] = self.lobes.range;
        if t < low || t > high {
            return [0.0; 3];
        }
        let last = self.samples.len() - 1;
        let place = (t - low) / (high - low) * last as f64;
        let index = (place as usize).min(last - 1);
        let part = place - index as f64;
        let (before, after) = (self.samples[index].xyz, self.samples[index + 1].xyz);
        std::array::from_fn(|c| before[c] + part * (after[c] - before[c]))
    }
}

/// Moments of the light of a lobe; wavenumbers in 1/µm.
struct Moments {
    /// X, Y, Z.
    xyz: [f64; 3],
    /// First moments of X, Y, Z about the mean.
    shift: [f64; 3],
    /// Mean wavenumber of all light.
    mean: f64,
    /// Standard deviation of the wavenumber of all light.
    deviation: f64,
}

impl Moments {
    /// All light at the mean wavenumber. The second half is zero.
    fn whole(&self) -> ([f64; 4], [f64; 4]) {
        let [x, y, z] = self.xyz;
        let wavelength_um = 1.0 / self.mean;
        ([x, y, z, wavelength_um], [0.0, 0.0, 0.0, wavelength_um])
    }

    /// The light at one standard deviation below and above the mean: Gauss's rule with two nodes. It preserves X, Y, Z,
    /// their first moments, and the second moment of all light.
    fn halves(&self) -> ([f64; 4], [f64; 4]) {
        if self.deviation == 0.0 {
            return self.whole();
        }
        let half = |sign: f64| {
            let part = |c: usize| 0.5 * (self.xyz[c] + sign * self.shift[c] / self.deviation);
            [part(0), part(1), part(2), 1.0 / (self.mean + sign * self.deviation)]
        };
        (half(-1.0), half(1.0))
    }
}
