//! Comparison of colours: exposure, which directions count, colour differences.

use crate::error::{Error, Result};
use crate::optics::colour::{D65_WHITE, ciede2000};

/// How far colours lie from a reference.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ColourDifference {
    /// Factor that colours are multiplied by before differences are taken. Default: `0.5 / p95(Y_ref)`.
    pub exposure: f64,
    /// Share of directions that are lit.
    pub lit: f64,
    /// Maximum difference of a tristimulus value, divided by the reference's maximum.
    pub max_abs: f64,
    /// Root mean square of these differences, divided by the reference's maximum.
    pub rms: f64,
    /// CIEDE2000 of the lit directions.
    pub de2000: Percentiles,
}

/// Mean and percentiles of colour differences.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Percentiles {
    /// Arithmetic mean.
    pub mean: f64,
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Maximum.
    pub max: f64,
}

/// Minimum exposed luminance of a lit direction.
pub const LIT: f64 = 1e-3;

/// `0.5 / p95(Y)` of the directions brighter than a millionth of the brightest; `None` if all are black.
pub fn auto_exposure(reference: &[[f64; 3]]) -> Option<f64> {
    let brightest = reference.iter().map(|c| c[1]).fold(0.0, f64::max);
    let mut bright: Vec<f64> =
        reference.iter().map(|c| c[1]).filter(|y| *y > 1e-6 * brightest).collect();
    bright.sort_unstable_by(f64::total_cmp);
    (brightest > 0.0).then(|| 0.5 / percentile(&bright, 0.95))
}

/// Compares colours direction by direction (tristimulus values, same order).
///
/// A direction is lit when the exposed luminance of either side reaches [`LIT`]. Statistics of colour differences use
/// lit directions only. Otherwise a black picture would pass wherever most of the reference is dark. It is an error if
/// no direction is lit.
pub fn colour_difference(
    subject: &str,
    reference: &[[f64; 3]],
    other: &[[f64; 3]],
    exposure: Option<f64>,
) -> Result<ColourDifference> {
    let fail = |cause: String| Error::new(subject, cause);
    if reference.len() != other.len() {
        return Err(fail(format!(
            "{} colours, but the reference has {}",
            other.len(),
            reference.len()
        )));
    }
    if let Some(at) = other.iter().position(|c| c.iter().any(|v| !v.is_finite())) {
        return Err(fail(format!("colour {at} is not finite: {:?}", other[at])));
    }
    let exposure = exposure
        .or_else(|| auto_exposure(reference))
        .ok_or_else(|| fail("the reference is black in every direction".into()))?;
    let largest = reference.iter().flatten().copied().fold(0.0, f64::max);
    let (mut max_abs, mut squares) = (0.0_f64, 0.0);
    let mut differences = Vec::new();
    for (a, b) in reference.iter().zip(other) {
        for c in 0..3 {
            let d = (a[c] - b[c]).abs() / largest;
            max_abs = max_abs.max(d);
            squares += d * d;
        }
        if exposure * a[1].max(b[1]) >= LIT {
            differences.push(ciede2000(expose(*a, exposure), expose(*b, exposure)));
        }
    }
    if differences.is_empty() {
        return Err(fail(format!("no direction is lit at exposure {exposure:e}")));
    }
    let lit = differences.len() as f64 / reference.len() as f64;
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    differences.sort_unstable_by(f64::total_cmp);
    let at = |p| percentile(&differences, p);
    let de2000 = Percentiles { mean, p50: at(0.5), p95: at(0.95), p99: at(0.99), max: at(1.0) };
    Ok(ColourDifference {
        exposure,
        lit,
        max_abs,
        rms: (squares / (3 * reference.len()) as f64).sqrt(),
        de2000,
    })
}

/// Minimum share of lit pixels for which a map is compared. A grating of one period lights only a thin line of the map,
/// or the flanks of one; there the random directions are the better test.
const MIN_LIT: f64 = 0.05;
/// Pixels darker than this share of the brightest direction do not count. A map of a grating may miss all orders and
/// show only their outermost flanks.
const DIM: f64 = 1e-6;

/// Compares the pixels of a map at its own exposure. `brightest` is the maximum luminance of all compared directions;
/// pixels below a millionth of it do not count. `lit` is the share of all pixels. `None` if less than a twentieth of the
/// map is lit.
pub fn map_difference(
    subject: &str,
    reference: &[[f64; 3]],
    other: &[[f64; 3]],
    brightest: f64,
    exposure: f64,
) -> Option<ColourDifference> {
    let seen = |(a, b): &(&[f64; 3], &[f64; 3])| a[1].max(b[1]) > DIM * brightest;
    let (expected, colours): (Vec<_>, Vec<_>) = reference.iter().zip(other).filter(seen).unzip();
    let share = expected.len() as f64 / reference.len() as f64;
    let compared = colour_difference(subject, &expected, &colours, Some(exposure)).ok()?;
    let lit = compared.lit * share;
    (lit >= MIN_LIT).then_some(ColourDifference { lit, ..compared })
}

fn expose(xyz: [f64; 3], exposure: f64) -> [f64; 3] {
    std::array::from_fn(|c| (exposure * xyz[c]).min(D65_WHITE[c]))
}

/// Linear between the two nearest ranks of sorted values (Hyndman & Fan 1996, definition 7).
fn percentile(sorted: &[f64], p: f64) -> f64 {
    let place = p * (sorted.len() - 1) as f64;
    let low = place.floor() as usize;
    let high = (low + 1).min(sorted.len() - 1);
    sorted[low] + (sorted[high] - sorted[low]) * (place - low as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Vec<[f64; 3]> {
        (1..=100).map(|i| D65_WHITE.map(|c| c * f64::from(i) * 0.01)).collect()
    }

    #[test]
    fn exposure_puts_the_95th_percentile_at_one_half() {
        let exposure = auto_exposure(&ramp()).expect("lit");
        assert!((exposure * 0.9505 - 0.5).abs() < 1e-12, "{exposure}");
        assert_eq!(auto_exposure(&[[0.0; 3]; 4]), None);
    }

    #[test]
    fn black_and_constant_pictures_are_far_from_the_truth() {
        let reference = ramp();
        let same = colour_difference("same", &reference, &reference, None).expect("lit");
        assert_eq!((same.max_abs, same.de2000.max), (0.0, 0.0));
        let black = colour_difference("black", &reference, &[[0.0; 3]; 100], None).expect("lit");
        assert!(black.de2000.mean > 30.0 && (black.max_abs - 1.0).abs() < 1e-12);
        let constant =
            colour_difference("constant", &reference, &[D65_WHITE; 100], None).expect("lit");
        assert!(constant.de2000.p50 > 10.0);
    }

    /// On a grating almost every direction is dark. A black picture must fail nevertheless.
    #[test]
    fn dark_directions_do_not_dilute() {
        let mut reference = vec![[0.0; 3]; 1000];
        reference[3] = D65_WHITE;
        let black =
            colour_difference("black", &reference, &vec![[0.0; 3]; 1000], None).expect("lit");
        assert!(black.de2000.p50 > 30.0 && (black.lit - 0.001).abs() < 1e-12);
    }

    #[test]
    fn nothing_lit_and_not_a_number_are_errors() {
        let black = [[0.0; 3]; 4];
        assert!(colour_difference("black", &black, &black, None).is_err());
        assert!(colour_difference("nan", &ramp(), &[[f64::NAN; 3]; 100], None).is_err());
    }
}
