//! The series of one bin in f64; see `templates/series.wgsl`.

use glam::DVec2;
use rustfft::num_complex::Complex64;

use crate::plan::Packing;

use super::Twin;

/// What the series is in.
pub enum Argument {
    /// z over its greatest value, times the ratio of the terms' scales.
    Power(f64),
    /// The coefficients of all terms.
    Coefficients(Vec<f64>),
}

/// What the series is in at one wavelength; coefficients are linear between their table's nodes.
pub fn series_argument(twin: &Twin<'_>, w: f64, lambda_um: f64) -> Argument {
    let tau = 0.5 * w * (twin.variant.wavelengths.min_nm * 1e-3) / lambda_um;
    let table = twin.coefficients;
    if table.width == 0 {
        return Argument::Power(tau * twin.resolved.scale.ratio);
    }
    let place = (1.0 + tau).clamp(0.0, 1.0) * (table.width - 1) as f64;
    let index = (place as i64).min(table.width as i64 - 2);
    let part = place - index as f64;
    let row = |row: usize| {
        let texel = |i: i64| table.load(i, row as i64, 0);
        let (before, after) = (texel(index), texel(index + 1));
        std::array::from_fn::<f64, 4, _>(|c| before[c] + part * (after[c] - before[c]))
    };
    Argument::Coefficients((0..table.height).flat_map(row).collect())
}

/// Scale of the first term.
pub fn series_scale(twin: &Twin<'_>) -> f64 {
    twin.resolved.scale.first
}

/// The sum over terms of coefficient times table at one bin: `c_rs(z)` over the scale of the first term.
pub fn bin_amplitude(twin: &Twin<'_>, bin: DVec2, argument: &Argument) -> Complex64 {
    let column = bin.x as i64 + twin.resolved.bins.r_max as i64;
    let row = bin.y as i64 + twin.resolved.bins.s_max as i64;
    let paired = twin.variant.packing == Packing::Paired;
    let mut sum = Complex64::default();
    for layer in (0..twin.resolved.layers as usize).rev() {
        let [re, im, next_re, next_im] = twin.terms.load(column, row, layer);
        let (first, second) = (Complex64::new(re, im), Complex64::new(next_re, next_im));
        match argument {
            // Horner's rule
            Argument::Power(tau) if paired => sum = (sum * tau + second) * tau + first,
            Argument::Power(tau) => sum = sum * tau + first,
            Argument::Coefficients(all) if paired => {
                sum += first * all[2 * layer] + second * all[2 * layer + 1];
            }
            Argument::Coefficients(all) => sum += first * all[layer],
        }
    }
    sum
}
