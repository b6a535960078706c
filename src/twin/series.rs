//! The power series of one bin in f64; see `templates/series.wgsl`.

use glam::DVec2;
use rustfft::num_complex::Complex64;

use crate::plan::Packing;

use super::Twin;

/// What the series is in: z over its greatest value, times the ratio of the terms' scales.
pub fn series_argument(twin: &Twin<'_>, w: f64, lambda_um: f64) -> f64 {
    let tau = 0.5 * w * (twin.variant.wavelengths.min_nm * 1e-3) / lambda_um;
    tau * twin.resolved.scale.ratio
}

/// Scale of the first term.
pub fn series_scale(twin: &Twin<'_>) -> f64 {
    twin.resolved.scale.first
}

/// `Σ_n τ^n table_n` of one bin, by Horner's rule: `c_rs(z)` over the scale of the first term.
pub fn bin_amplitude(twin: &Twin<'_>, bin: DVec2, tau: f64) -> Complex64 {
    let column = bin.x as i64 + twin.resolved.bins.r_max as i64;
    let row = bin.y as i64 + twin.resolved.bins.s_max as i64;
    let mut sum = Complex64::default();
    for layer in (0..twin.resolved.layers as usize).rev() {
        let [re, im, next_re, next_im] = twin.terms.load(column, row, layer);
        if twin.variant.packing == Packing::Paired {
            sum = sum * tau + Complex64::new(next_re, next_im);
        }
        sum = sum * tau + Complex64::new(re, im);
    }
    sum
}
