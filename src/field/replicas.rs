//! A surface made of `Qx × Qy` replicas of the patch, without a coherence window (the texts' PQ).

use std::f64::consts::PI;

use glam::DVec2;
use rustfft::num_complex::Complex64;

use crate::field::phase_sum;
use crate::surface::HeightField;

/// `A(t) = sin(πQt)/(Q sin πt)`, the normalised sum of `Q` unit phasors at steps of `t` turns about their middle; its
/// limit at whole `t` is ±1. The sum of `Q` terms is divided by `Q`. The texts divide a sum of `N + 1` terms by `N`,
/// which makes a jump at whole `t`.
pub fn replica_factor(t: f64, q: u32) -> f64 {
    let nearest = t.round();
    let rest = t - nearest;
    let sign = if (nearest as i64 * (i64::from(q) - 1)).rem_euclid(2) == 0 { 1.0 } else { -1.0 };
    let q = f64::from(q);
    if rest.abs() < 1e-9 {
        // here 1 - (Q² - 1)(π rest)²/6 differs from 1 by less than 1e-16, for every Q that follows from a coherence length
        return sign;
    }
    sign * (PI * q * rest).sin() / (q * (PI * rest).sin())
}

/// `sin πt/(πt)`. The sine is taken within half a turn of its zero, so that whole `t` give 0.
pub fn sinc(t: f64) -> f64 {
    if t == 0.0 {
        return 1.0;
    }
    let nearest = t.round();
    let sign = if nearest.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
    sign * (PI * (t - nearest)).sin() / (PI * t)
}

/// Amplitude of the replicas, `A(fx Lx)·A(fy Ly)·P1(f)`, `P1` the transform of one patch at a continuous frequency,
/// cycles per µm. The product of complex factors has imaginary part `p1 q2 + q1 p2`.
pub fn amplitude(height: &HeightField, f: DVec2, z: f64, [qx, qy]: [u32; 2]) -> Complex64 {
    let turns = f * DVec2::new(height.size_x_um(), height.size_y_um());
    phase_sum(height, f, z) * replica_factor(turns.x, qx) * replica_factor(turns.y, qy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sinc_is_one_at_zero_and_zero_at_other_whole_turns() {
        assert_eq!(
            [sinc(0.0), sinc(1e-300), sinc(-3.0), sinc(70.0)].map(f64::abs),
            [1.0, 1.0, 0.0, 0.0]
        );
        for t in [0.3, -0.5, 0.5, 1.4, -2.6, 17.2] {
            assert!((sinc(t) - (PI * t).sin() / (PI * t)).abs() < 1e-14, "{t}");
        }
    }

    fn surface() -> HeightField {
        HeightField::new(4, 3, 0.3, 0.2, (0..12).map(|i| f64::from(i * i % 7) * 0.05).collect())
            .expect("valid")
    }

    /// The replicas side by side, summed directly.
    fn direct(height: &HeightField, f: DVec2, z: f64, [qx, qy]: [u32; 2]) -> Complex64 {
        let (columns, rows) = (height.columns() * qx as usize, height.rows() * qy as usize);
        let at = |i: usize| {
            height.heights_um()
                [(i / columns % height.rows()) * height.columns() + i % columns % height.columns()]
        };
        let many = HeightField::new(columns, rows, 0.3, 0.2, (0..columns * rows).map(at).collect())
            .expect("valid");
        phase_sum(&many, f, z)
    }

    #[test]
    fn factors_are_the_sum_over_replicas() {
        let height = surface();
        for q in [[1, 1], [2, 1], [3, 2], [4, 5]] {
            for f in [
                DVec2::new(0.31, -0.77),
                DVec2::new(1.0 / 1.2, 0.4),
                DVec2::ZERO,
                DVec2::new(1.7, 1.0 / 0.6),
            ] {
                let (fast, slow) = (amplitude(&height, f, -14.0, q), direct(&height, f, -14.0, q));
                assert!((fast - slow).norm() < 1e-9, "{q:?} {f}: {fast} against {slow}");
            }
        }
    }

    /// The misprint `p1 p2 + q1 q2` for the imaginary part doubles the intensity of a real peak, so it must fail clearly.
    #[test]
    fn the_misprinted_product_is_another_number() {
        let (a, b) = (Complex64::new(0.8, 0.1), Complex64::new(0.9, -0.2));
        let misprinted = Complex64::new(a.re * b.re - a.im * b.im, a.re * b.re + a.im * b.im);
        assert!(misprinted.norm_sqr() > 1.7 * (a * b).norm_sqr());
        let height = surface();
        let (f, q) = (DVec2::new(1.0 / 1.2, 1.0 / 0.6), [2, 2]);
        assert!(
            amplitude(&height, f, -14.0, q).norm_sqr()
                <= direct(&height, f, -14.0, q).norm_sqr() + 1e-9
        );
    }

    #[test]
    fn the_factor_is_continuous_at_its_limit() {
        for q in [1, 2, 5, 26] {
            for whole in [-2.0, 0.0, 1.0] {
                let at = replica_factor(whole, q);
                assert!((at.abs() - 1.0).abs() < 1e-15);
                assert!((replica_factor(whole + 2e-9, q) - at).abs() < 1e-12, "{q} {whole}");
            }
        }
        // an (N+1)-term sum over N would be (N+1)/N there
        assert!((replica_factor(1e-7, 5) - 6.0 / 5.0).abs() > 0.19);
    }
}
