//! Scales of the terms in tables of 16-bit floats.

use crate::tables::basis::Expansion;

use super::TermScale;

/// Maximum number that is stored. The format's maximum is 65504; the rest is a margin for rounding, including rounding
/// of the ratio.
const LARGEST: f64 = 32768.0;
/// Terms below this share of the largest are too small for 16 bits and do not influence the sequence.
const RELEVANT: f64 = 1e-6;

/// The geometric sequence through the bounds `x^n/n!`, `x = z_max·reach`, of the first and the last relevant term,
/// raised so that no term exceeds the format. They are bounds of every bin of a term's transform, since `|x^n/n!|`
/// bounds the term itself.
pub(super) fn scale(expansion: &Expansion) -> TermScale {
    let x = expansion.z_max * expansion.reach_um;
    let mut bounds = vec![1.0];
    for n in 1..expansion.terms {
        // the functions of other bases are at most 1; their magnitude is in the coefficients
        let part = if expansion.is_tabulated() { 1.0 } else { x / f64::from(n) };
        bounds.push(bounds[n as usize - 1] * part);
    }
    let largest = bounds.iter().copied().fold(0.0, f64::max);
    let last = bounds.iter().rposition(|b| *b >= RELEVANT * largest).unwrap_or(0);
    let first = bounds.iter().position(|b| *b >= RELEVANT * largest).unwrap_or(0);
    let ratio = if last > first {
        single((bounds[last] / bounds[first]).powf(1.0 / (last - first) as f64))
    } else {
        1.0
    };
    let mut sequence = 1.0;
    let mut raise = 0.0_f64;
    for bound in bounds {
        raise = raise.max(bound / sequence);
        sequence *= ratio;
    }
    TermScale { first: single(raise / LARGEST), ratio }
}

fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Basis;
    use crate::surface::HeightField;

    #[test]
    fn no_term_overflows_and_the_relevant_ones_are_normal_numbers() {
        for (height_um, terms) in [(1e-4, 5), (0.3, 31), (0.36, 40), (1.0, 80), (3.0, 200)] {
            let field = HeightField::new(2, 1, 0.05, 0.05, vec![0.0, height_um]).expect("valid");
            for basis in [Basis::Taylor, Basis::TaylorZero] {
                let expansion = Expansion::new(basis, terms, &field, 380.0);
                let scale = scale(&expansion);
                let x = expansion.z_max * expansion.reach_um;
                let bounds: Vec<f64> =
                    (0..terms).map(|n| (1..=n).fold(1.0, |p, i| p * x / f64::from(i))).collect();
                let largest = bounds.iter().copied().fold(0.0, f64::max);
                for (n, bound) in bounds.iter().enumerate() {
                    let stored = bound / scale.of(n);
                    assert!(stored < 40000.0, "{height_um} term {n}: {stored}");
                    assert!(
                        stored > 6.2e-5 || *bound < 1e-6 * largest,
                        "{height_um} term {n}: {stored:e}"
                    );
                }
            }
        }
    }
}
