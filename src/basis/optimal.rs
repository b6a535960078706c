//! The fewest terms for one surface: singular functions of `exp(i z h)` over the z range and the heights that occur.

use super::curve::{Curve, enough_nodes, nodes, series};
use super::jacobi::singular;

/// A range of heights that the surface has, in parts of its reach, both signs folded into one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Least, mean and greatest of its heights.
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
    let level = |([least, sum, greatest], count): ([f64; 3], usize)| {
        let mean = (sum / count as f64).clamp(least, greatest);
        Level { places: [least, mean, greatest], share: count as f64 / all as f64 }
    };
    filled.map(level).collect()
}

/// Terms of `exp(i phase s x)` for `s` in `[-1, 1]` and `x` among the levels, the most important first; terms below rounding
/// are left out. The cosine and the sine are decomposed apart: that keeps all coefficients real.
pub fn optimal(phase: f64, levels: &[Level]) -> Vec<Curve> {
    let count = enough_nodes(phase);
    let places = nodes(count);
    // the nodes, which are dense towards the ends where errors are greatest, are the weights along z
    let half = &places[..count / 2];
    // rare heights count a little more than their share, so that none is given up
    let floor = FLOOR / levels.len() as f64;
    let weights: Vec<f64> =
        levels.iter().map(|level| (floor + (1.0 - FLOOR) * level.share).sqrt()).collect();
    let part = |odd: bool| -> Vec<(f64, Curve)> {
        let wave = |argument: f64| if odd { argument.sin() } else { argument.cos() };
        let column = |s: &f64| {
            let value =
                |(level, weight): (&Level, &f64)| weight * wave(phase * s * level.places[1]);
            levels.iter().zip(&weights).map(value).collect()
        };
        let found = singular(half.iter().map(column).collect());
        let curve = |vector: &[f64]| curve(vector, half, &places, phase, odd);
        found.iter().map(|(size, vector)| (*size, curve(vector))).collect()
    };
    let mut terms = part(false);
    terms.extend(part(true));
    terms.sort_by(|a, b| b.0.total_cmp(&a.0));
    let most = terms.first().map_or(0.0, |(size, _)| *size);
    terms.into_iter().take_while(|(size, _)| *size > 1e-13 * most).map(|(_, curve)| curve).collect()
}

/// Share of the weight along h that is the same for all heights that occur.
const FLOOR: f64 = 0.2;

/// A singular vector as a function of s, and the projection of the wave on it as a function of x, whose greatest value
/// goes over to the former.
fn curve(vector: &[f64], half: &[f64], places: &[f64], phase: f64, odd: bool) -> Curve {
    let project = |x: &f64| -> f64 {
        let wave = |s: f64| if odd { (phase * s * x).sin() } else { (phase * s * x).cos() };
        vector.iter().zip(half).map(|(v, s)| v * wave(*s)).sum()
    };
    let mirrored = vector.iter().rev().map(|v| if odd { -v } else { *v });
    let values: Vec<f64> = vector.iter().copied().chain(mirrored).collect();
    let heights: Vec<f64> = places.iter().map(project).collect();
    let fine = (0..=4 * places.len()).map(|i| project(&(i as f64 / (4 * places.len()) as f64)));
    let most = fine.fold(f64::MIN_POSITIVE, |most, v| most.max(v.abs()));
    Curve {
        along_z: series(&values).iter().map(|c| c * most).collect(),
        along_h: series(&heights).iter().map(|c| c / most).collect(),
        turns: u32::from(odd),
    }
}
