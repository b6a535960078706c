//! Replicas of the patch in f64; see `templates/pq.wgsl`.
//!
//! `P1(f) = Σ_rs c_rs D(fx Lx - r) D(fy Ly - s)`, `D(t) = e^(-iπt/N) sin πt / (N sin(πt/N))`: the pixels begin at
//! `-L/2`, so their middle is half a pixel before the origin. The sum is exact over any N consecutive bins of an axis.
//! It is truncated to `2·radius + 1` bins around the frequency.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rustfft::num_complex::Complex64;

use crate::field::replicas;
use crate::variant::Pq;

use super::Twin;
use super::bins::bin_amplitude;
use super::series::{series_argument, series_scale};

/// `|P|²` at one wavelength, µm, along `path = (u, v, w)`.
pub fn response(twin: &Twin<'_>, form: &Pq, path: DVec3, lambda_um: f64) -> f64 {
    let place = path.truncate() / lambda_um * DVec2::from(form.series.size_um);
    let [columns, rows] = form.taps.map(f64::from);
    let first = (place - 0.5 * DVec2::new(columns - 1.0, rows - 1.0) + 0.5).floor();
    let tau = series_argument(twin, &form.series, &form.coat, path.z, lambda_um);
    let [pixel_columns, pixel_rows] = form.pixels.map(f64::from);
    let mut amplitude = Complex64::default();
    for s in 0..form.taps[1] {
        let row = first.y + f64::from(s);
        let weight = kernel(place.y - row, pixel_rows);
        for r in 0..form.taps[0] {
            let column = first.x + f64::from(r);
            let tap = complex_product(weight, kernel(place.x - column, pixel_columns));
            amplitude += complex_product(
                tap,
                bin_amplitude(twin, &form.series, DVec2::new(column, row), tau),
            );
        }
    }
    let [qx, qy] = form.periods.map(f64::from);
    let factor = replica_factor(place.x, qx) * replica_factor(place.y, qy);
    (factor * series_scale(&form.series)).powi(2) * amplitude.norm_sqr()
}

/// The periodic sinc at an offset in bins, half-pixel phase included.
fn kernel(offset: f64, pixels: f64) -> Complex64 {
    Complex64::cis(-PI * offset / pixels) * (sinc(offset) / sinc(offset / pixels))
}

/// `sin(πQt)/(Q sin πt)` up to its sign; 1 at whole `t`.
fn replica_factor(place: f64, periods: f64) -> f64 {
    let rest = place - (place + 0.5).floor();
    sinc(periods * rest) / sinc(rest)
}

/// `sin πt/(πt)`. The template uses the series of the sine, which is exact to 4e-10.
fn sinc(turns: f64) -> f64 {
    replicas::sinc(turns)
}

/// `(p + iq)(r + is)`; its imaginary part is `ps + qr`.
fn complex_product(a: Complex64, b: Complex64) -> Complex64 {
    a * b
}
