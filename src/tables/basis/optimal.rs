//! The minimum number of terms for one surface: singular functions of `exp(i z h)` over the z range and the heights that occur.

use super::curve::{Curve, enough_nodes, nodes, series};
use super::jacobi::singular;

/// A range of heights that occur on the surface, relative to its reach. Heights of both signs are combined by magnitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Minimum, mean and maximum of its heights.
    pub places: [f64; 3],
    /// Share of the surface's pixels.
    pub share: f64,
}

/// The heights of a surface, `x` in `[-1, 1]`, by their magnitude; ranges without heights are left out.
pub fn levels(x: impl Iterator<Item = f64>) -> Vec<Level> {
    const BINS: usize = 256;
    let mut bins = vec![([f64::MAX, 0.0, 0.0_f64], 0_usize); BINS];
    let mut all = 0;
    for x in x {
        let x = x.abs().min(1.0);
        let (places, count) = &mut bins[((x * BINS as f64) as usize).min(BINS - 1)];
        *places = [places[0].min(x), places[1] + x, places[2].max(x)];
        *count += 1;
        all += 1;
    }
    let filled = bins.into_iter().filter(|(_, count)| *count > 0);
    let level = |([min, sum, max], count): ([f64; 3], usize)| {
        let mean = (sum / count as f64).clamp(min, max);
        Level { places: [min, mean, max], share: count as f64 / all as f64 }
    };
    filled.map(level).collect()
}

/// Terms of `exp(i phase s x)` for `s` in `[-1, 1]` and `x` among the levels, in descending order of importance. Terms
/// below rounding errors are omitted. The terms are optimal for `|s|` up to `part`. Beyond, each coefficient is the
/// projection on the term's height function. Cosine and sine are decomposed separately, which keeps all coefficients
/// real.
pub fn optimal(phase: f64, part: f64, levels: &[Level]) -> Vec<Curve> {
    let within = nodes(enough_nodes(phase * part));
    // nodes are denser towards the ends, where errors are largest, and this density is the weight along z
    let half: Vec<f64> = within[..within.len() / 2].iter().map(|s| part * s).collect();
    let places = nodes(enough_nodes(phase));
    // rare heights have a little more weight than their share, so that no height is neglected
    let floor = FLOOR / levels.len() as f64;
    let weights: Vec<f64> =
        levels.iter().map(|level| floor + (1.0 - FLOOR) * level.share).collect();
    let terms = |odd: bool| -> Vec<(f64, Curve)> {
        let wave = |s: f64, x: f64| if odd { (phase * s * x).sin() } else { (phase * s * x).cos() };
        let column = |s: &f64| {
            let value = |(level, weight): (&Level, &f64)| weight.sqrt() * wave(*s, level.places[1]);
            levels.iter().zip(&weights).map(value).collect()
        };
        let found = singular(half.iter().map(column).collect());
        let mut known: Vec<Along> = Vec::new();
        let curve = |(size, vector): &(f64, Vec<f64>)| {
            let sum = |x: f64| vector.iter().zip(&half).map(|(v, s)| v * wave(*s, x)).sum();
            let along = Along::new(sum, levels, &weights, &places).apart_from(&known);
            let coefficient = |s: &f64| {
                let waves = levels.iter().map(|level| wave(*s, level.places[1]));
                along.weighted.iter().zip(waves).map(|(b, wave)| b * wave).sum::<f64>() / along.norm
            };
            let values: Vec<f64> = places.iter().map(coefficient).collect();
            let heights = series(&along.at_nodes);
            known.push(along);
            (*size, Curve { along_z: series(&values), along_h: heights, turns: u32::from(odd) })
        };
        found.iter().map(curve).collect()
    };
    let mut all = terms(false);
    all.extend(terms(true));
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let max = all.first().map_or(0.0, |(size, _)| *size);
    all.into_iter().take_while(|(size, _)| *size > 1e-13 * max).map(|(_, curve)| curve).collect()
}

/// Share of the weight along h that is distributed equally over all heights that occur.
const FLOOR: f64 = 0.2;

/// A height function whose maximum is 1.
struct Along {
    at_nodes: Vec<f64>,
    at_levels: Vec<f64>,
    /// Its values at the levels, times the weights of the levels.
    weighted: Vec<f64>,
    /// Its weighted square, summed over the levels.
    norm: f64,
}

impl Along {
    fn new(value: impl Fn(f64) -> f64, levels: &[Level], weights: &[f64], places: &[f64]) -> Along {
        let at_nodes = places.iter().map(|x| value(*x)).collect();
        let at_levels: Vec<f64> = levels.iter().map(|level| value(level.places[1])).collect();
        let weighted = at_levels.iter().zip(weights).map(|(b, weight)| b * weight).collect();
        Along { at_nodes, at_levels, weighted, norm: 1.0 }.scaled()
    }

    /// Removes the components of known functions. Small terms are of the size of the rounding errors of large ones, and
    /// keep all their digits only without these components.
    fn apart_from(mut self, known: &[Along]) -> Along {
        for other in known {
            let part = dot(&self.at_levels, &other.weighted) / other.norm;
            for (own, its) in [
                (&mut self.at_nodes, &other.at_nodes),
                (&mut self.at_levels, &other.at_levels),
                (&mut self.weighted, &other.weighted),
            ] {
                own.iter_mut().zip(its).for_each(|(own, its)| *own -= part * its);
            }
        }
        self.scaled()
    }

    fn scaled(mut self) -> Along {
        let all = self.at_nodes.iter().chain(&self.at_levels);
        let max = all.fold(f64::MIN_POSITIVE, |max, v| max.max(v.abs()));
        for values in [&mut self.at_nodes, &mut self.at_levels, &mut self.weighted] {
            values.iter_mut().for_each(|v| *v /= max);
        }
        self.norm = dot(&self.at_levels, &self.weighted);
        self
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
