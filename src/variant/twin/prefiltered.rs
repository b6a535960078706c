//! The amplitude between the texels of a table in f64; see `templates/prefiltered.wgsl`.

use glam::{DVec2, DVec3};
use rustfft::num_complex::Complex64;

use crate::plan::Packing;
use crate::tables::{Series, bilinear};
use crate::variant::Coat;

use super::Twin;
use super::series::{series_argument, series_scale};

/// `|P|²` at one wavelength, µm, along `path = (u, v, w)`.
pub fn response(twin: &Twin<'_>, series: &Series, coat: &Coat, path: DVec3, lambda_um: f64) -> f64 {
    series_scale(series).powi(2) * intensity(twin, series, coat, path, lambda_um)
}

/// The same, divided by the squared scale of the first term.
pub fn intensity(
    twin: &Twin<'_>,
    series: &Series,
    coat: &Coat,
    path: DVec3,
    lambda_um: f64,
) -> f64 {
    let place = path.truncate() / lambda_um * DVec2::from(series.size_um);
    let argument = series_argument(twin, series, coat, path.z, lambda_um);
    amplitude(twin, series, place, argument).norm_sqr()
}

/// The sum over terms of coefficient times table, at a position in texels from the central texel.
fn amplitude(twin: &Twin<'_>, series: &Series, place: DVec2, argument: f64) -> Complex64 {
    let paired = series.packing == Packing::Paired;
    let layers = series.layers() as usize;
    let terms = |layer: usize| {
        let [re, im, next_re, next_im] = texel_between(twin, series, place, layer);
        [Complex64::new(re, im), Complex64::new(next_re, next_im)]
    };
    let mut sum = Complex64::default();
    if twin.coefficients.width == 0 {
        // Horner's rule
        for [first, second] in (0..layers).rev().map(terms) {
            if paired {
                sum = sum * argument + second;
            }
            sum = sum * argument + first;
        }
        return sum;
    }
    let node = (argument + 0.5) as i64;
    for layer in 0..layers {
        let [first, second] = terms(layer);
        let (term, count) = if paired { (2 * layer, 2) } else { (layer, 1) };
        let four = twin.coefficients.load(node, (term / 4) as i64, 0);
        sum += first * four[term % 4];
        if count == 2 {
            sum += second * four[term % 4 + 1];
        }
    }
    sum
}

/// A layer of the terms, interpolated between texels. Positions are counted from the centre of the central texel.
fn texel_between(twin: &Twin<'_>, series: &Series, place: DVec2, layer: usize) -> [f64; 4] {
    let bins = series.bins;
    let middle = DVec2::new(bins.r_max as f64, bins.s_max as f64);
    bilinear(twin.terms, (place + middle).to_array(), layer)
}
