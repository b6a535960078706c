//! Statistics of repeated measurements, without an assumption about the distribution of times.
//!
//! Times of frames are skewed, because other work can only add to them. So medians are used, not means, and intervals come
//! from order statistics, not from a normal distribution.

/// Probability that an [`interval`] contains the true median, if there are at least [`MIN_VALUES`] values.
pub const CONFIDENCE: f64 = 0.95;

/// Minimum number of values whose range contains the median with [`CONFIDENCE`]: `1 - 2·2⁻⁶ = 0.969`.
pub const MIN_VALUES: usize = 6;

/// Modified z-score above which a value is an outlier: B. Iglewicz and D. Hoaglin, *How to Detect and Handle Outliers* (ASQC,
/// 1993).
pub const OUTLIER_SCORE: f64 = 3.5;

/// Summary of a list of values, in their unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// The median.
    pub median: f64,
    /// Median of the absolute deviations from the median, without a factor.
    pub mad: f64,
    /// Confidence interval of the median, see [`interval`].
    pub interval: [f64; 2],
    /// Number of values whose modified z-score is above [`OUTLIER_SCORE`]. They are not removed.
    pub outliers: usize,
}

/// Summarises a list of finite values; `None` for an empty list.
pub fn summary(values: &[f64]) -> Option<Summary> {
    Some(Summary {
        median: median(values)?,
        mad: mad(values)?,
        interval: interval(values)?,
        outliers: scores(values).into_iter().filter(|score| score.abs() > OUTLIER_SCORE).count(),
    })
}

/// The middle value, or the mean of the two middle values.
pub fn median(values: &[f64]) -> Option<f64> {
    let sorted = sorted(values);
    let half = sorted.len() / 2;
    match sorted.len() % 2 {
        _ if sorted.is_empty() => None,
        1 => Some(sorted[half]),
        _ => Some(0.5 * (sorted[half - 1] + sorted[half])),
    }
}

/// Median of the absolute deviations from the median.
pub fn mad(values: &[f64]) -> Option<f64> {
    let centre = median(values)?;
    median(&deviations(values, centre))
}

/// Confidence interval of the median, without an assumption about the distribution: the `k`-th value from either end. `k` is
/// the largest number for which `P(B < k)`, `B` binomial of `n` tosses of a fair coin, is at most half of `1 -` [`CONFIDENCE`]
/// (W. J. Conover, *Practical Nonparametric Statistics*, 1971, chapter 3). Fewer than [`MIN_VALUES`] values give their
/// minimum and maximum, which contain the median less often.
pub fn interval(values: &[f64]) -> Option<[f64; 2]> {
    let sorted = sorted(values);
    let from_end = sorted.len().checked_sub(1)?;
    let skipped = interval_rank(sorted.len()).saturating_sub(1);
    Some([sorted[skipped], sorted[from_end - skipped]])
}

/// Rank `k`, counted from 1, of the ends of [`interval`]; 0 if even the minimum and maximum do not suffice.
pub fn interval_rank(count: usize) -> usize {
    let allowed = 0.5 * (1.0 - CONFIDENCE);
    // in logarithms, since 2⁻ⁿ underflows
    let mut log_term = -(count as f64) * std::f64::consts::LN_2;
    let mut below = 0.0;
    for k in 0..=count / 2 {
        below += log_term.exp();
        if below > allowed {
            return k;
        }
        log_term += ((count - k) as f64 / (k + 1) as f64).ln();
    }
    count / 2
}

/// Modified z-scores `0.6745·(x - median)/MAD`. If more than half of the values are equal, the MAD is 0; then
/// `(x - median)/(1.2533·mean absolute deviation)`, as Iglewicz and Hoaglin propose. 0 if all values are equal.
pub fn scores(values: &[f64]) -> Vec<f64> {
    let (Some(centre), Some(mad)) = (median(values), mad(values)) else { return Vec::new() };
    let mean = deviations(values, centre).iter().sum::<f64>() / values.len() as f64;
    // sqrt(π/2) and the third quartile of the normal distribution
    let scale = if mad > 0.0 { mad / 0.6745 } else { 1.2533 * mean };
    let score = |value: &f64| if scale > 0.0 { (value - centre) / scale } else { 0.0 };
    values.iter().map(score).collect()
}

/// Half of the width of an interval, over the value inside it.
pub fn relative_width(value: f64, [low, high]: [f64; 2]) -> f64 {
    0.5 * (high - low) / value.abs()
}

/// Exponent `p` of the power law `y ∝ xᵖ` by least squares in logarithms; `None` without two different positive `x`.
pub fn exponent(points: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> =
        points.iter().filter(|p| p[0] > 0.0 && p[1] > 0.0).map(|p| p.map(f64::ln)).collect();
    let mean = |axis: usize| logs.iter().map(|p| p[axis]).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let spread: f64 = logs.iter().map(|p| (p[0] - x).powi(2)).sum();
    let common: f64 = logs.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    (spread > 1e-12).then(|| common / spread)
}

fn deviations(values: &[f64], centre: f64) -> Vec<f64> {
    values.iter().map(|value| (value - centre).abs()).collect()
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_deviations_of_small_lists() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[9.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(mad(&[1.0, 1.0, 2.0, 2.0, 4.0, 6.0, 9.0]), Some(1.0));
        assert_eq!(summary(&[]), None);
    }

    #[test]
    fn ranks_are_those_of_the_tables() {
        // tables of the sign test at 5 %, two-sided: the critical value is one less
        for (count, rank) in
            [(5, 0), (6, 1), (8, 1), (9, 2), (10, 2), (12, 3), (15, 4), (20, 6), (25, 8), (50, 18)]
        {
            assert_eq!(interval_rank(count), rank, "{count}");
        }
        assert_eq!(interval_rank(MIN_VALUES - 1), 0);
        // far beyond the range of 2⁻ⁿ; the normal approximation gives 2500 - 98
        assert!((interval_rank(10_000) as f64 - 4902.0).abs() < 2.0);
    }

    #[test]
    fn intervals_are_order_statistics() {
        let values: Vec<f64> = (1..=20).rev().map(f64::from).collect();
        assert_eq!(interval(&values), Some([6.0, 15.0]));
        assert_eq!(interval(&[2.0, 1.0, 3.0]), Some([1.0, 3.0]));
        assert_eq!(relative_width(10.0, [9.0, 12.0]), 0.15);
    }

    #[test]
    fn outliers_are_those_of_the_handbook() {
        // median 2.2, MAD 0.1: 0.6745·7.8/0.1
        let values = [2.1, 2.6, 2.3, 2.2, 2.2, 2.1, 10.0];
        let last = scores(&values)[6];
        assert!((last - 52.611).abs() < 1e-9, "{last}");
        assert_eq!(summary(&values).map(|s| s.outliers), Some(1));
        // more than half equal: mean absolute deviation 1.25
        let equal = [[1.0; 7].as_slice(), &[11.0]].concat();
        assert!((scores(&equal)[7] - 10.0 / (1.2533 * 1.25)).abs() < 1e-9);
        assert_eq!(summary(&equal).map(|s| s.outliers), Some(1));
        assert_eq!(scores(&[5.0; 4]), [0.0; 4]);
    }

    #[test]
    fn exponents_of_power_laws() {
        let law = |p: f64| [1.0, 2.0, 4.0, 8.0].map(|x: f64| [x, 3.0 * x.powf(p)]);
        for p in [-0.5, 1.0, 2.0] {
            assert!((exponent(&law(p)).expect("points") - p).abs() < 1e-12, "{p}");
        }
        assert_eq!(exponent(&[[2.0, 1.0], [2.0, 3.0]]), None);
    }
}
