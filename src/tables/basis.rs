//! Expansions `exp(i z h) ≈ phase · Σ_{n<T} a_n(z) b_n(h)` of the phase function, with bounds of their errors.

mod bessel;
mod curve;
mod jacobi;
mod optimal;

use crate::plan::Basis;
use crate::surface::HeightField;

pub use bessel::bessel;
pub use curve::Curve;

use curve::{enough_nodes, nodes, series};
use optimal::{Level, levels, optimal};

/// A term basis for one surface.
///
/// Taylor series: with `x = z_max·(h - origin)` and `τ = z/z_max ∈ [-1, 1]`, `b_n(h) = (i x)^n / n!` and `a_n = τ^n`.
/// The factor `exp(i z origin)` is a pure phase and cancels in `|P|²`. In this form the shader contains no number of
/// the surface, and tables and coefficients stay within the range of a 32-bit float.
///
/// The other bases have functions of their own, `b_n(h) = exp(i z_c (h - origin)) i^m v_n((h - origin)/reach)` and real
/// `a_n(z)`. A shader reads these from a table at equal steps of `z` in `[-z_max, 0]`, with linear interpolation.
#[derive(Clone, Debug, PartialEq)]
pub struct Expansion {
    /// Which basis.
    pub basis: Basis,
    /// Number of terms `T`; the highest power is `T - 1`.
    pub terms: u32,
    /// Height about which the series is taken, µm.
    pub origin_um: f64,
    /// Maximum `|h - origin|`, µm.
    pub reach_um: f64,
    /// Maximum `|z|`, 1/µm: `2·2π/λmin`.
    pub z_max: f64,
    /// Minimum `|z|`, 1/µm: 0 without a cover. Only the basis `optimal` uses it.
    pub least_z: f64,
    /// Maximum `|z|` for which the basis `optimal` is optimised, 1/µm. From there to `z_max` its error grows.
    pub best_z: f64,
    /// The terms of a basis with functions of its own; empty for a power series. Terms beyond the last are zero.
    pub curves: Vec<Curve>,
    /// Error with 0, 1, 2 … of these terms, each for `|s|` up to `i/last` of its range, `i` from 0.
    truncation: Vec<Vec<f64>>,
}

impl Expansion {
    /// A basis for a surface and all wavelengths from `min_nm` up, with equal weight. This is the right choice for a
    /// bound on the error.
    pub fn new(basis: Basis, terms: u32, height: &HeightField, min_nm: f64) -> Expansion {
        Expansion::over((0.0, min_nm), min_nm, basis, terms, height)
    }

    /// A basis that is optimised for wavelengths from `best_nm` up and is valid from `min_nm` up. This is the right
    /// choice for colours: if the shortest wavelengths had equal weight, every term would serve light that is hardly
    /// visible as much as all other light. Only the basis `optimal` depends on `best_nm`.
    ///
    /// Under a cover `least_z` is the least phase per height, and wavelengths are those in air with the same greatest
    /// phase per height.
    pub fn over(
        (least_z, min_nm): (f64, f64),
        best_nm: f64,
        basis: Basis,
        terms: u32,
        height: &HeightField,
    ) -> Expansion {
        let (low_um, high_um) = height.range_um();
        let (origin_um, reach_um) = match basis {
            Basis::TaylorZero => (low_um, high_um - low_um),
            _ => (0.5 * (low_um + high_um), 0.5 * (high_um - low_um)),
        };
        let z_max = max_z(min_nm);
        let best_z = max_z(best_nm.max(min_nm));
        let (curves, truncation) = match basis {
            Basis::Taylor | Basis::TaylorZero => (Vec::new(), Vec::new()),
            Basis::Chebyshev => chebyshev(z_max * reach_um),
            Basis::Optimal => {
                let part = |h: &f64| if reach_um > 0.0 { (h - origin_um) / reach_um } else { 0.0 };
                let levels = levels(height.heights_um().iter().map(part));
                let half = z_max - 0.5 * (least_z + best_z);
                let phase = half * reach_um;
                let curves = optimal(phase, 0.5 * (best_z - least_z) / half, &levels);
                let truncation = measured(&curves, phase, &levels);
                (curves, truncation)
            }
        };
        Expansion { basis, terms, origin_um, reach_um, z_max, least_z, best_z, curves, truncation }
    }

    /// Whether the coefficients are a table. Otherwise they are powers of `z/z_max`.
    pub fn is_tabulated(&self) -> bool {
        is_tabulated(self.basis)
    }

    /// Bound of the phase function's error for every height of the surface and every `z`, including the error of linear
    /// interpolation between nodes.
    pub fn bound(&self) -> f64 {
        self.bound_to(self.z_max)
    }

    /// The same for `|z|` up to a limit in 1/µm: longer wavelengths have smaller errors.
    pub fn bound_to(&self, z: f64) -> f64 {
        match self.basis {
            Basis::Taylor | Basis::TaylorZero => remainder(z * self.reach_um, self.terms),
            _ => self.cut(self.terms, self.part(z)) + self.between(self.nodes()),
        }
    }

    /// The share of the range of `s` that a table of coefficients uses for `|z|` up to a limit.
    fn part(&self, z: f64) -> f64 {
        let centre = -self.centre_z();
        ((centre - self.least_z).max(z - centre) / (self.z_max - centre)).clamp(0.0, 1.0)
    }

    /// The same expansion with the minimum number of terms whose bound is at most `error`.
    #[must_use]
    pub fn with_error(self, error: f64) -> Expansion {
        let x = self.z_max * self.reach_um;
        let enough = |terms: &u32| match self.basis {
            Basis::Taylor | Basis::TaylorZero => remainder(x, *terms) <= error,
            _ => self.cut(*terms, 1.0) + self.between(self.nodes_for(*terms)) <= error,
        };
        let terms = (1..=MAX_TERMS).find(enough).unwrap_or(MAX_TERMS);
        Expansion { terms, ..self }
    }

    /// Maximum `|a_n b_n|` of every term.
    pub fn term_sizes(&self) -> Vec<f64> {
        let x = self.z_max * self.reach_um;
        let size = |n: u32| match self.curves.get(n as usize) {
            Some(curve) => curve.along_z.iter().map(|c| c.abs()).sum(),
            None if self.is_tabulated() => 0.0,
            None => remainder(x, n),
        };
        (0..self.terms).map(size).collect()
    }

    /// Middle of the z range, 1/µm. Its phase is part of the tables, so the coefficients cover only half of the range
    /// to either side.
    pub fn centre_z(&self) -> f64 {
        if self.basis == Basis::Optimal { -0.5 * (self.least_z + self.best_z) } else { 0.0 }
    }

    /// Coefficient of a term at `z = τ·z_max`, `τ` in `[-1, 0]`.
    pub fn coefficient(&self, term: usize, tau: f64) -> f64 {
        match self.curves.get(term) {
            Some(curve) if self.basis == Basis::Optimal => {
                let centre = -self.centre_z();
                curve.coefficient((tau * self.z_max + centre) / (self.z_max - centre))
            }
            Some(curve) => curve.coefficient(tau),
            None if self.is_tabulated() => 0.0,
            None => tau.powi(term as i32),
        }
    }

    /// Number of nodes of the table of coefficients, a power of two; 0 without such a table. The error between nodes is
    /// a small part of the error of the omitted terms.
    pub fn nodes(&self) -> usize {
        if self.is_tabulated() { self.nodes_for(self.terms) } else { 0 }
    }

    fn nodes_for(&self, terms: u32) -> usize {
        let mut count = MIN_NODES;
        while count < MAX_NODES && self.between(count) > INTERPOLATION * self.cut(terms, 1.0) {
            count *= 2;
        }
        count
    }

    /// Error of linear interpolation: `δ²/8` times the maximum second derivative of `exp(i (z - z_c)(h - origin))`.
    fn between(&self, count: usize) -> f64 {
        (self.z_max * self.reach_um / (count - 1) as f64).powi(2) / 8.0
    }

    /// Error of the omitted terms for `|s|` up to `part`.
    fn cut(&self, terms: u32, part: f64) -> f64 {
        let last = self.truncation.len().saturating_sub(1);
        let Some(errors) = self.truncation.get((terms as usize).min(last)) else { return 1.0 };
        errors[(part * (errors.len() - 1) as f64).ceil() as usize]
    }
}

/// Whether the coefficients of a basis are stored in a table.
pub fn is_tabulated(basis: Basis) -> bool {
    matches!(basis, Basis::Chebyshev | Basis::Optimal)
}

/// Minimum number of nodes of a table of coefficients.
const MIN_NODES: usize = 64;
/// Maximum number of nodes: every profile allows textures of this width.
const MAX_NODES: usize = 2048;
/// Error of interpolation, relative to the error of the omitted terms.
const INTERPOLATION: f64 = 0.05;

/// Jacobi–Anger expansion: `exp(i phase s x) = Σ (2 - δ_n0) i^n J_n(phase s) T_n(x)`. After `T` terms the error is at
/// most `Σ_{n≥T} 2 max|J_n|`.
fn chebyshev(phase: f64) -> (Vec<Curve>, Vec<Vec<f64>>) {
    let count = enough_nodes(phase).min(MAX_TERMS as usize);
    let twice = |n: usize| if n == 0 { 1.0 } else { 2.0 };
    let values: Vec<Vec<f64>> =
        nodes(enough_nodes(phase)).iter().map(|s| bessel(count, phase * s)).collect();
    let curve = |n: usize| {
        let along_z: Vec<f64> = values.iter().map(|all| twice(n) * all[n]).collect();
        let mut along_h = vec![0.0; n + 1];
        along_h[n] = 1.0;
        Curve { along_z: series(&along_z), along_h, turns: n as u32 % 4 }
    };
    let omitted = |part: f64| -> Vec<f64> {
        let phase = part * phase;
        let at_most = |(n, value): (usize, &f64)| match n {
            // an order above the argument has its maximum at the end of the range; lower orders are below 1/√2
            _ if n as f64 >= phase => value.abs(),
            0 => 1.0,
            _ => std::f64::consts::FRAC_1_SQRT_2,
        };
        let end = bessel(2 * count, phase);
        let mut errors: Vec<f64> = end.iter().enumerate().map(|t| 2.0 * at_most(t)).collect();
        for n in (1..errors.len()).rev() {
            errors[n - 1] += errors[n];
        }
        errors
    };
    let parts: Vec<Vec<f64>> = (0..=PARTS).map(|i| omitted(i as f64 / PARTS as f64)).collect();
    let truncation = (0..=count).map(|terms| parts.iter().map(|errors| errors[terms]).collect());
    ((0..count).map(curve).collect(), truncation.collect())
}

/// Number of ranges of `s` for which `chebyshev` knows its error.
const PARTS: usize = 64;

/// Maximum error for every number of terms, up to every place of the z range, over the heights that occur. Cosine, sine
/// and their terms are even or odd in `s` and in `x`, so one quadrant suffices.
fn measured(curves: &[Curve], phase: f64, levels: &[Level]) -> Vec<Vec<f64>> {
    let steps = 4 * enough_nodes(phase);
    let places: Vec<f64> = (0..=steps).map(|i| i as f64 / steps as f64).collect();
    let mut heights: Vec<f64> = levels.iter().flat_map(|level| level.places).collect();
    heights.dedup();
    let wave = |s: &f64, x: &f64| (phase * s * x).sin_cos();
    let mut rest: Vec<(f64, f64)> =
        places.iter().flat_map(|s| heights.iter().map(move |x| wave(s, x))).collect();
    let count = heights.len();
    let largest = |rest: &[(f64, f64)]| {
        let mut max: f64 = 0.0;
        let up_to = rest.chunks(count).map(|row| {
            max = row.iter().fold(max, |max, (odd, even)| max.max(odd * odd + even * even));
            SLACK * max.sqrt()
        });
        up_to.collect::<Vec<f64>>()
    };
    let mut found = vec![largest(&rest)];
    for curve in curves {
        let along_h: Vec<f64> = heights.iter().map(|x| curve.height(*x)).collect();
        for (row, s) in rest.chunks_mut(count).zip(&places) {
            let coefficient = curve.coefficient(*s);
            for ((odd, even), b) in row.iter_mut().zip(&along_h) {
                *(if curve.turns == 1 { odd } else { even }) -= coefficient * b;
            }
        }
        found.push(largest(&rest));
    }
    found
}

/// Allowance for errors between the sampled points.
const SLACK: f64 = 1.02;

/// Maximum number of terms, chosen or configured.
pub const MAX_TERMS: u32 = 200;

/// Maximum `|z| = k|w|` at wavelengths from `min_nm` up. It occurs with both directions along the normal.
pub fn max_z(min_nm: f64) -> f64 {
    2.0 * std::f64::consts::TAU / (min_nm * 1e-3)
}

/// `x^T/T!`: the remainder of `exp(i x)` after `T` terms (Taylor's theorem; all derivatives have modulus 1).
pub fn remainder(x: f64, terms: u32) -> f64 {
    (1..=terms).fold(1.0, |product, n| product * x.abs() / f64::from(n))
}

/// The bound that the texts derive from Lagrange's remainder, `exp(x)·x^(N+1)/(N+1)!` for the polynomial of degree `N`.
/// It is larger than [`remainder`] by a factor of `exp(x)`, because it bounds the derivatives of a real exponential.
pub fn lagrange_bound(x: f64, degree: u32) -> f64 {
    x.exp() * remainder(x, degree + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustfft::num_complex::Complex64;

    /// The numbers of the texts, for x_max = 1.5π.
    #[test]
    fn lagrange_bound_of_the_texts() {
        let x = 1.5 * std::f64::consts::PI;
        for (degree, want) in [(20, 3.0e-4), (25, 8.8e-8), (30, 1.0e-11)] {
            let got = lagrange_bound(x, degree);
            assert!((got / want - 1.0).abs() < 0.02, "N = {degree}: {got:e}");
        }
    }

    /// For a range of 0.36 µm and a maximum error of 1e-2, 19 centred terms are needed, or 35 from zero; and the bound holds.
    #[test]
    fn term_counts_for_one_percent_and_the_bound_is_one() {
        let height = HeightField::new(2, 1, 0.05, 0.05, vec![0.1, 0.46]).expect("valid");
        for (basis, terms) in [(Basis::Taylor, 19), (Basis::TaylorZero, 35)] {
            let expansion = Expansion::new(basis, 1, &height, 380.0).with_error(1e-2);
            assert_eq!(expansion.terms, terms);
            for h in [0.1, 0.2, 0.46] {
                let x = expansion.z_max * (h - expansion.origin_um);
                let mut term = Complex64::new(1.0, 0.0);
                let mut sum = Complex64::default();
                for n in 0..terms {
                    sum += term;
                    term *= Complex64::new(0.0, x / f64::from(n + 1));
                }
                assert!((sum - Complex64::cis(x)).norm() <= expansion.bound() * 1.000001);
            }
            let fewer = Expansion { terms: terms - 1, ..expansion };
            assert!(fewer.bound() > 1e-2);
        }
    }

    #[test]
    fn a_flat_surface_needs_one_term() {
        let height = HeightField::new(2, 2, 0.05, 0.05, vec![0.3; 4]).expect("valid");
        assert_eq!(Expansion::new(Basis::Taylor, 9, &height, 380.0).with_error(1e-3).terms, 1);
    }
}
