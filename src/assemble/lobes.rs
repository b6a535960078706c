//! The colours of lobes: a Gaussian of wavenumbers under the colour weights, for the mode `adaptive`.

use std::f64::consts::{PI, SQRT_2};

use rayon::prelude::*;

use crate::plan::Variant;
use crate::resolve::{BROADEST, Lobes, REACH_SIGMAS, Resolved};
use crate::spectrum::Sample;
use crate::tables::{Table, lobe_table};

/// Nodes of the midpoint rule over a lobe, cut to the range; whole ones of 4√2 standard deviations are exact to 1e-9.
const STEPS: u32 = 64;

/// The spectrum table; `samples` are the colour weights per 1/µm at equal steps of the wavenumber over the range.
pub fn lobes_table(
    samples: &[Sample],
    variant: &Variant,
    resolved: &Resolved,
    rotate_deg: f64,
) -> Table {
    let lobes = Lobes::new(variant, resolved.patch_um);
    let corridor = resolved.corridor;
    let weights = Weights { samples, lobes: &lobes };
    let pace = lobes.pace(corridor.nodes);
    let broad = |node: u32| {
        let bell =
            |t: f64, other: u32| (-((t - lobes.node(other, corridor.nodes)) / pace).powi(2)).exp();
        // together the nodes weigh every wavenumber once
        let kernel =
            |t: f64| bell(t, node) / (0..corridor.nodes).map(|other| bell(t, other)).sum::<f64>();
        let middle = lobes.node(node, corridor.nodes);
        let reach = REACH_SIGMAS * pace;
        weights.integral([middle - reach, middle + reach], kernel)
    };
    let nodes = (0..corridor.nodes).into_par_iter().map(broad).collect();
    let [low, high] = lobes.middles(corridor.nodes);
    let place = |i: u32, count: u32| f64::from(i) / f64::from(count - 1);
    let cells = 0..corridor.rows * corridor.columns;
    let narrow = |cell: u32| {
        let (row, column) = (cell / corridor.columns, cell % corridor.columns);
        let middle = low + (high - low) * place(column, corridor.columns);
        weights.narrow(middle, place(row, corridor.rows) * BROADEST * pace)
    };
    let narrow = cells.into_par_iter().map(narrow).collect();
    lobe_table(nodes, narrow, corridor.columns as usize, rotate_deg, resolved.scale)
}

struct Weights<'a> {
    samples: &'a [Sample],
    lobes: &'a Lobes,
}

impl Weights<'_> {
    /// A narrow lobe that is so wide at the long end of the range, over `σf/|(u, v)|` of 1/µm.
    fn narrow(&self, middle: f64, width: f64) -> [f64; 4] {
        let Lobes { range: [low, high], scales, .. } = *self.lobes;
        if width == 0.0 {
            let [x, y, z] =
                self.at(middle).map(|c| c * PI.sqrt() * if scales { middle } else { 1.0 });
            return [x, y, z, 1.0 / middle.clamp(low, high)];
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

    /// X, Y, Z under a kernel between two wavenumbers, and the wavelength of their mean wavenumber, µm.
    fn integral(&self, [from, to]: [f64; 2], kernel: impl Fn(f64) -> f64) -> [f64; 4] {
        let [low, high] = self.lobes.range;
        let (from, to) = (from.max(low), to.min(high));
        let step = (to - from).max(0.0) / f64::from(STEPS);
        let mut sum = [0.0; 3];
        let (mut total, mut moment) = (0.0, 0.0);
        for i in 0..STEPS {
            let t = from + (f64::from(i) + 0.5) * step;
            let share = step * kernel(t);
            let xyz = self.at(t).map(|c| c * share);
            let light: f64 = xyz.iter().sum();
            total += light;
            moment += t * light;
            sum.iter_mut().zip(xyz).for_each(|(sum, c)| *sum += c);
        }
        let mean = if total > 0.0 { moment / total } else { 0.5 * (from + to) };
        [sum[0], sum[1], sum[2], 1.0 / mean.clamp(low, high)]
    }

    /// The weights at a wavenumber, linear between the samples, nothing outside.
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
