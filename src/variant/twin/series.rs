//! The argument of the series and the scale of its terms in f64; see `templates/series.wgsl`.

use crate::tables::Series;
use crate::variant::Coat;

use super::Twin;
use super::matter::dispersed;

/// Argument of the series: z divided by its maximum, times the ratio of the terms' scales; or the column in the table
/// of coefficients.
pub fn series_argument(
    twin: &Twin<'_>,
    series: &Series,
    coat: &Coat,
    w: f64,
    lambda_um: f64,
) -> f64 {
    let w = dispersed(twin, coat, w, lambda_um);
    let tau = 0.5 * w * (series.phase_min_nm() * 1e-3) / lambda_um;
    match twin.coefficients.width {
        0 => tau * series.scale().ratio,
        nodes => (1.0 + tau).clamp(0.0, 1.0) * (nodes - 1) as f64,
    }
}

/// Scale of the first term.
pub fn series_scale(series: &Series) -> f64 {
    series.scale().first
}
