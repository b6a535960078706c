//! Closed forms of gratings, the yardstick of the estimate.

use std::f64::consts::{PI, TAU};

use diffraction_shaders::field::replicas::sinc;
use diffraction_shaders::plan::Grating;
use rustfft::num_complex::Complex64;

/// One period of a grating along x, with the exact transform of `exp(i z h)`.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedForm {
    shape: Shape,
    /// Period, µm.
    pub period_um: f64,
    height_um: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Sinusoidal,
    Blazed,
    Lamellar { duty: f64 },
    Triangle { apex: f64 },
}

/// What determines the width of an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lobe {
    /// A Gaussian coherence window of this standard deviation, µm.
    Window {
        /// Standard deviation, µm.
        sigma_um: f64,
    },
    /// A finite number of periods along x with sharp ends, and a finite length of the groove along y.
    Replicas {
        /// Number of periods.
        periods: f64,
        /// Length along y, µm.
        length_um: f64,
    },
}

impl ClosedForm {
    /// The closed form of a synthetic surface; `None` if it has no closed form.
    pub fn new(grating: &Grating) -> Option<ClosedForm> {
        let profile = |shape, period_um, height_um| ClosedForm { shape, period_um, height_um };
        match *grating {
            Grating::Sinusoidal { period_um, height_um, .. } => {
                Some(profile(Shape::Sinusoidal, period_um, height_um))
            }
            Grating::Blazed { period_um, height_um, .. } => {
                Some(profile(Shape::Blazed, period_um, height_um))
            }
            Grating::Lamellar { period_um, height_um, duty, .. } => {
                Some(profile(Shape::Lamellar { duty }, period_um, height_um))
            }
            Grating::Triangle { period_um, height_um, apex, .. } => {
                Some(profile(Shape::Triangle { apex }, period_um, height_um))
            }
            _ => None,
        }
    }

    /// `∫₀¹ exp(i z h(t)) exp(2πi t place) dt`, `t = x/d`: the transform of one period. For an integer `place = m` it is `c_m`.
    pub fn transform(&self, place: f64, z: f64) -> Complex64 {
        let psi = z * self.height_um;
        // ∫₀^share exp(i rise s/share) exp(2πi place s) ds
        let ramp = |rise: f64, place: f64, share: f64| {
            let half = 0.5 * (rise + TAU * place * share);
            Complex64::cis(half) * (share * sinc(half / PI))
        };
        match self.shape {
            Shape::Blazed => ramp(psi, place, 1.0),
            Shape::Lamellar { duty } => {
                Complex64::cis(psi) * ramp(0.0, place, duty)
                    + Complex64::cis(TAU * place * duty) * ramp(0.0, place, 1.0 - duty)
            }
            Shape::Triangle { apex } => {
                ramp(psi, place, apex) + Complex64::cis(TAU * place) * ramp(psi, -place, 1.0 - apex)
            }
            // Jacobi–Anger: exp(iζ cos φ) = Σ iⁿ J_n(ζ) exp(inφ)
            Shape::Sinusoidal => {
                let zeta = 0.5 * psi;
                let max = zeta.abs() as i32 + 24;
                let term = |n: i32| {
                    let shifted = place + f64::from(n);
                    let factor = Complex64::i().powi(n) * Complex64::cis(PI * shifted);
                    factor * (libm::jn(n, zeta) * sinc(shifted))
                };
                Complex64::cis(zeta) * (-max..=max).map(term).sum::<Complex64>()
            }
        }
    }

    /// `|P|²` at `f = (fx, fy)`, cycles per µm, and `z`, 1/µm. Assumes that orders do not overlap.
    pub fn response(&self, [fx, fy]: [f64; 2], z: f64, lobe: Lobe) -> f64 {
        let place = fx * self.period_um;
        match lobe {
            Lobe::Window { sigma_um } => {
                let order = place.round();
                let off = [(place - order) / self.period_um, fy];
                let squared = off[0] * off[0] + off[1] * off[1];
                self.transform(order, z).norm_sqr() * (-(TAU * sigma_um).powi(2) * squared).exp()
            }
            Lobe::Replicas { periods, length_um } => {
                let rest = place - place.round();
                let factor = sinc(periods * rest) / sinc(rest) * sinc(length_um * fy);
                self.transform(place, z).norm_sqr() * factor * factor
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Height in units of `H`, over the position in the period, 0 to 1.
    type Height = fn(f64) -> f64;

    fn all() -> [(ClosedForm, Height); 4] {
        let of = |shape| ClosedForm { shape, period_um: 2.5, height_um: 0.3 };
        [
            (of(Shape::Sinusoidal), |t| 0.5 + 0.5 * (TAU * t).cos()),
            (of(Shape::Blazed), |t| t),
            (of(Shape::Lamellar { duty: 0.375 }), |t| f64::from(u8::from(t < 0.375))),
            (of(Shape::Triangle { apex: 0.25 }), |t| {
                if t < 0.25 { t / 0.25 } else { (1.0 - t) / 0.75 }
            }),
        ]
    }

    #[test]
    fn transforms_are_the_integrals() {
        const COUNT: usize = 8000;
        for (profile, height) in all() {
            for place in [-3.0, -1.0, 0.0, 2.0, -1.37, 0.4] {
                for z in [-22.2, -3.1] {
                    let term = |i: usize| {
                        let t = (i as f64 + 0.5) / COUNT as f64;
                        Complex64::cis(z * 0.3 * height(t) + TAU * place * t)
                    };
                    let sum: Complex64 = (0..COUNT).map(term).sum::<Complex64>() / COUNT as f64;
                    let got = profile.transform(place, z);
                    assert!((got - sum).norm() < 1e-5, "{profile:?} {place}: {got} against {sum}");
                }
            }
        }
    }

    #[test]
    fn at_an_order_both_lobes_are_the_efficiency() {
        for (profile, _) in all() {
            let efficiency = profile.transform(-1.0, -15.0).norm_sqr();
            let lobes = [
                Lobe::Window { sigma_um: 16.25 },
                Lobe::Replicas { periods: 26.0, length_um: 65.0 },
            ];
            for lobe in lobes {
                let at = |fx: f64, fy: f64| profile.response([fx, fy], -15.0, lobe);
                assert!((at(-0.4, 0.0) - efficiency).abs() < 1e-12);
                assert!(at(-0.4, 0.05) < 0.1 * efficiency && at(-0.25, 0.0) < 0.1 * efficiency);
            }
        }
    }
}
