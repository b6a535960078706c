//! Expansions `exp(i z h) ≈ phase · Σ_{n<T} a_n(z) b_n(h)` of the phase function, with their bounds.

use crate::height::HeightField;
use crate::plan::Basis;

/// A term basis laid on one surface.
///
/// Taylor series: with `x = z_max·(h - origin)` and `τ = z/z_max ∈ [-1, 1]`, `b_n(h) = (i x)^n / n!` and `a_n = τ^n`.
/// The factor `exp(i z origin)` is a pure phase and cancels in `|P|²`. Written so, no number of the surface enters the
/// shader, and neither tables nor coefficients leave the range of a 32-bit float.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expansion {
    /// Which basis.
    pub basis: Basis,
    /// Number of terms `T`; the highest power is `T - 1`.
    pub terms: u32,
    /// Height about which the series is taken, µm.
    pub origin_um: f64,
    /// Greatest `|h - origin|`, µm.
    pub reach_um: f64,
    /// Greatest `|z|`, 1/µm: `2·2π/λmin`.
    pub z_max: f64,
}

impl Expansion {
    /// Lays a basis on a surface for wavelengths from `min_nm` up.
    pub fn new(basis: Basis, terms: u32, height: &HeightField, min_nm: f64) -> Expansion {
        let (low_um, high_um) = height.range_um();
        let (origin_um, reach_um) = match basis {
            Basis::Taylor => (0.5 * (low_um + high_um), 0.5 * (high_um - low_um)),
            Basis::TaylorZero => (low_um, high_um - low_um),
        };
        Expansion { basis, terms, origin_um, reach_um, z_max: greatest_z(min_nm) }
    }

    /// A-priori bound of the phase function's error for every height of the surface and every `z`.
    pub fn bound(&self) -> f64 {
        remainder(self.z_max * self.reach_um, self.terms)
    }

    /// The same expansion with the fewest terms whose bound is at most `error`.
    #[must_use]
    pub fn with_error(self, error: f64) -> Expansion {
        let x = self.z_max * self.reach_um;
        let terms = (1..=MOST_TERMS).find(|&t| remainder(x, t) <= error).unwrap_or(MOST_TERMS);
        Expansion { terms, ..self }
    }
}

/// More terms than this are never chosen nor accepted.
pub const MOST_TERMS: u32 = 200;

/// Greatest `|z| = k|w|` at wavelengths from `min_nm` up: both directions along the normal.
pub fn greatest_z(min_nm: f64) -> f64 {
    2.0 * std::f64::consts::TAU / (min_nm * 1e-3)
}

/// `x^T/T!`: the remainder of `exp(i x)` after `T` terms (Taylor's theorem; all derivatives have modulus 1).
pub fn remainder(x: f64, terms: u32) -> f64 {
    (1..=terms).fold(1.0, |product, n| product * x.abs() / f64::from(n))
}

/// The bound that the texts derive after Lagrange, `exp(x)·x^(N+1)/(N+1)!` for the polynomial of degree `N`; larger than
/// [`remainder`] by `exp(x)`, because it bounds the derivatives of a real exponential.
pub fn lagrange_bound(x: f64, degree: u32) -> f64 {
    x.exp() * remainder(x, degree + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustfft::num_complex::Complex64;

    /// The figures of the texts: x_max = 1.5π.
    #[test]
    fn lagrange_bound_of_the_texts() {
        let x = 1.5 * std::f64::consts::PI;
        for (degree, want) in [(20, 3.0e-4), (25, 8.8e-8), (30, 1.0e-11)] {
            let got = lagrange_bound(x, degree);
            assert!((got / want - 1.0).abs() < 0.02, "N = {degree}: {got:e}");
        }
    }

    /// Range 0.36 µm, sup error 1e-2: 19 terms centred, 35 from zero; and the bound holds.
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
