//! Pairs of functions `a(z) b(h)`, each a series of Chebyshev polynomials.

use std::f64::consts::PI;

/// One term: `a(s)·i^turns·b(x)`, `s` and `x` in `[-1, 1]`, `a` and `b` real, `|b| ≤ 1`.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Coefficients of `a` in Chebyshev polynomials of `s`.
    pub along_z: Vec<f64>,
    /// Coefficients of `b` in Chebyshev polynomials of `x`.
    pub along_h: Vec<f64>,
    /// Quarter turns of the term's phase.
    pub turns: u32,
}

impl Curve {
    /// The coefficient `a` at `s`.
    pub fn coefficient(&self, s: f64) -> f64 {
        clenshaw(&self.along_z, s)
    }

    /// The height function `b` at `x`, without its quarter turns.
    pub fn height(&self, x: f64) -> f64 {
        clenshaw(&self.along_h, x)
    }
}

/// `cos(π(j + 1/2)/count)`: the zeros of the Chebyshev polynomial of that degree, descending.
pub fn nodes(count: usize) -> Vec<f64> {
    (0..count).map(|j| angle(j, count).cos()).collect()
}

/// The series through values at [`nodes`].
pub fn series(values: &[f64]) -> Vec<f64> {
    let count = values.len();
    let coefficient = |m: usize| {
        let terms = values.iter().enumerate();
        let sum: f64 = terms.map(|(j, v)| v * (m as f64 * angle(j, count)).cos()).sum();
        sum * if m == 0 { 1.0 } else { 2.0 } / count as f64
    };
    (0..count).map(coefficient).collect()
}

/// Number of nodes that suffices for every function of `s` that oscillates like `exp(i phase s)`.
pub fn enough_nodes(phase: f64) -> usize {
    // above its argument, a Bessel function decreases over a number of orders of about the argument's cube root
    2 * (0.5 * phase.abs() + 6.0 * phase.abs().cbrt() + 10.0).ceil() as usize
}

fn angle(index: usize, count: usize) -> f64 {
    PI * (index as f64 + 0.5) / count as f64
}

/// `Σ c_m T_m(x)`.
fn clenshaw(coefficients: &[f64], x: f64) -> f64 {
    let Some((first, rest)) = coefficients.split_first() else { return 0.0 };
    let (next, after) =
        rest.iter().rev().fold((0.0, 0.0), |(next, after), c| (c + 2.0 * x * next - after, next));
    first + x * next - after
}
