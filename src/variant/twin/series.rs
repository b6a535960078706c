//! The argument of the series and the scale of its terms in f64; see `templates/series.wgsl`.

use crate::tables::Series;

use super::Twin;

/// Argument of the series: z divided by its maximum, times the ratio of the terms' scales; or the column in the table
/// of coefficients.
pub fn series_argument(twin: &Twin<'_>, series: &Series, w: f64, lambda_um: f64) -> f64 {
    let tau = 0.5 * w * (series.min_nm() * 1e-3) / lambda_um;
    match twin.coefficients.width {
        0 => tau * series.scale().ratio,
        nodes => (1.0 + tau).clamp(0.0, 1.0) * (nodes - 1) as f64,
    }
}

/// Scale of the first term.
pub fn series_scale(series: &Series) -> f64 {
    series.scale().first
}
