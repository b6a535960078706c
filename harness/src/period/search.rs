//! Finds the largest response on the grid of angles, without evaluating the whole grid.
//!
//! `|P|²` has no spatial frequency above `extent/λ` per unit of `sin θ`. So no lobe is missed by samples an eighth of `λ/extent`
//! apart: the largest of them is within a few per cent of the maximum. The grid is therefore evaluated only around coarse
//! maxima that are near the largest.

use std::collections::BTreeMap;

use diffraction_shaders::error::Result;

use super::{GRID_DEG, Protocol};

/// Number of coarse samples per `λ/extent`.
const PER_LOBE: f64 = 8.0;
/// Coarse maxima below this share of the largest cannot contain the maximum. In the worst case, midway between samples, an
/// isolated lobe of a Gaussian window or of replicas has lost 2 %.
const NEAR_LARGEST: f64 = 0.9;
/// Minimum response of a peak. Below it is rounding, not light: the amplitude of the exact field, 1 at its peak, is right to
/// 1e-9.
const MIN_RESPONSE: f64 = 1e-18;
/// Maximum grid index on either side. The horizon is left out.
const LAST: i32 = 8999;
/// Range in which the first order is searched, in units of its expected distance from the mirror direction.
const SEARCH: [f64; 2] = [0.5, 1.5];

/// The largest response near the first order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Signed viewing angle, degrees, between grid points.
    pub theta_deg: f64,
    /// Response at the nearest grid point.
    pub response: f64,
    /// `λ/|sin θr - sin θi|`, nm.
    pub period_nm: f64,
}

/// Samples at one wavelength, by grid index.
pub(super) type Samples = BTreeMap<i32, f64>;

/// The signed angle of a grid index, degrees.
pub(super) fn angle_deg(index: i32) -> f64 {
    f64::from(index) / (1.0 / GRID_DEG).round()
}

/// Number of grid points from one coarse sample to the next.
pub(super) fn stride(extent_um: f64, lambda_nm: f64) -> i32 {
    let step_deg = (lambda_nm * 1e-3 / (PER_LOBE * extent_um)).to_degrees();
    ((step_deg / GRID_DEG) as i32).clamp(1, 50)
}

/// Evaluates coarse samples, and every grid point around the maxima near the largest.
pub(super) fn scan(
    protocol: &Protocol,
    lambda_nm: f64,
    stride: i32,
    mut respond: impl FnMut(&[f64]) -> Result<Vec<f64>>,
) -> Result<Samples> {
    let mut samples = Samples::new();
    let mut add = |samples: &mut Samples, indices: Vec<i32>| -> Result<()> {
        if !indices.is_empty() {
            let angles: Vec<f64> = indices.iter().map(|&i| angle_deg(i)).collect();
            samples.extend(indices.into_iter().zip(respond(&angles)?));
        }
        Ok(())
    };
    let ranges = ranges(protocol, lambda_nm);
    let inside = |i: i32| protocol.whole || ranges.iter().any(|r| (r.0..=r.1).contains(&i));
    let mut coarse: Vec<i32> =
        (-LAST / stride..=LAST / stride).map(|k| k * stride).filter(|&i| inside(i)).collect();
    coarse.extend(ranges.iter().flat_map(|r| [r.0, r.1]));
    coarse.sort_unstable();
    coarse.dedup();
    add(&mut samples, coarse)?;
    let maxima: Vec<_> = ranges.iter().flat_map(|r| maxima(&samples, *r)).collect();
    let largest = maxima.iter().map(|m| m.1).fold(0.0, f64::max);
    let near = maxima.iter().filter(|m| m.1 >= NEAR_LARGEST * largest);
    let fine: std::collections::BTreeSet<i32> = near.flat_map(|m| m.0[0]..=m.0[2]).collect();
    let missing = fine.into_iter().filter(|i| !samples.contains_key(i)).collect();
    add(&mut samples, missing)?;
    Ok(samples)
}

/// The largest maximum among samples whose two neighbours on the grid are sampled as well.
pub(super) fn peak(protocol: &Protocol, lambda_nm: f64, samples: &Samples) -> Option<Peak> {
    let maxima = ranges(protocol, lambda_nm).into_iter().flat_map(|r| maxima(samples, r));
    let whole = maxima.filter(|([a, b, c], _)| b - a == 1 && c - b == 1);
    let ([before, at, after], response) = whole.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let shift = vertex([before, at, after].map(|i| samples[&i]));
    let theta_deg = angle_deg(at) + shift * GRID_DEG;
    let distance = (theta_deg.to_radians().sin() - protocol.sin_theta_i()).abs();
    Some(Peak { theta_deg, response, period_nm: lambda_nm / distance })
}

/// Vertex of the parabola through the logarithms of three equidistant responses, in steps from the middle one, which is the
/// largest. Exact for a Gaussian.
fn vertex(responses: [f64; 3]) -> f64 {
    let [a, b, c] = responses.map(|r| r.max(f64::MIN_POSITIVE).ln());
    let curvature = a - 2.0 * b + c;
    if curvature < 0.0 { (0.5 * (a - c) / curvature).clamp(-0.5, 0.5) } else { 0.0 }
}

/// Neighbouring samples `[before, at, after]` within a range whose middle one is a maximum, with its response. The ends of a
/// range do not count: a rise towards them belongs to the mirror direction or to another order.
fn maxima(samples: &Samples, (first, last): (i32, i32)) -> Vec<([i32; 3], f64)> {
    let inside: Vec<(i32, f64)> = samples.range(first..=last).map(|(i, r)| (*i, *r)).collect();
    let is_maximum =
        |w: &&[(i32, f64)]| w[1].1 > MIN_RESPONSE && w[1].1 >= w[0].1 && w[1].1 > w[2].1;
    let found = inside.windows(3).filter(is_maximum);
    found.map(|w| ([w[0].0, w[1].0, w[2].0], w[1].1)).collect()
}

/// First and last grid index of the searched range, on each side of the mirror direction.
fn ranges(protocol: &Protocol, lambda_nm: f64) -> Vec<(i32, i32)> {
    let sin_i = protocol.sin_theta_i();
    let distance = lambda_nm * 1e-3 / protocol.expected_um;
    let side = |sign: f64| {
        let ends = SEARCH.map(|share| sin_i + sign * share * distance);
        let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        if high < -1.0 || low > 1.0 {
            return None;
        }
        let index = |sin: f64| sin.clamp(-1.0, 1.0).asin().to_degrees() / GRID_DEG;
        let first = ((index(low) - 1e-6).ceil() as i32).max(-LAST);
        let last = ((index(high) + 1e-6).floor() as i32).min(LAST);
        (first <= last).then_some((first, last))
    };
    [-1.0, 1.0].into_iter().filter_map(side).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use diffraction_shaders::plan::Wavelengths;

    fn protocol(expected_um: f64) -> Protocol {
        let wavelengths = Wavelengths { min_nm: 550.0, max_nm: 550.0, step_nm: 5.0 };
        Protocol { theta_i_deg: 75.0, phi_i_deg: 0.0, wavelengths, expected_um, whole: false }
    }

    #[test]
    fn the_parabola_is_exact_for_a_gaussian() {
        for at in [-0.5, -0.31, 0.0, 0.2, 0.499] {
            let gaussian = |x: f64| 3.0 * (-0.7 * (x - at) * (x - at)).exp();
            assert!((vertex([-1.0, 0.0, 1.0].map(gaussian)) - at).abs() < 1e-12, "{at}");
        }
        assert_eq!(vertex([0.0, 1.0, 0.0]), 0.0);
        assert_eq!(vertex([1.0; 3]), 0.0);
    }

    #[test]
    fn the_search_is_where_the_first_order_is() {
        // sin 75° - λ/d, λ/d = 0.22, from 0.5 to 1.5 times; the other side is beyond the horizon
        let found = ranges(&protocol(2.5), 550.0);
        assert_eq!(found.len(), 1);
        let sin = |i: i32| angle_deg(i).to_radians().sin();
        let sin_i = 75.0_f64.to_radians().sin();
        assert!((sin_i - sin(found[0].0) - 0.33).abs() < 2e-4);
        assert!((sin_i - sin(found[0].1) - 0.11).abs() < 2e-4);
        assert!(sin_i - sin(found[0].0) <= 0.33 && sin_i - sin(found[0].1) >= 0.11);
        // below the normal the angle is negative
        assert!(ranges(&protocol(0.7), 550.0)[0].0 < -500);
        assert!(ranges(&protocol(0.1), 550.0).is_empty());
    }

    /// A slope, however high, is not a peak. A lobe is a peak, even if it is lower than the end of the slope.
    #[test]
    fn the_end_of_the_range_is_no_peak() {
        let lobe = |i: i32| (-(f64::from(i - 100) / 4.0).powi(2)).exp();
        let slope = |i: i32| 0.1 * f64::from(i - 80);
        let samples: Samples = (80..=200).map(|i| (i, slope(i))).collect();
        assert!(maxima(&samples, (80, 200)).is_empty());
        let samples: Samples = (80..=120).map(|i| (i, lobe(i) + 0.001 * slope(i))).collect();
        assert_eq!(maxima(&samples, (80, 120)).len(), 1);
    }
}
