//! The full sum in f64; see `templates/full.wgsl`, and `templates/thesis.wgsl` for the same sum in another order.

use glam::{DVec2, DVec3};
use rustfft::num_complex::Complex64;

use crate::plan::Coherence;
use crate::variant::FullWindow;

use super::Twin;
use super::bins::bin_amplitude;
use super::series::{series_argument, series_scale};
use super::window::{window, window_sharpness};

/// `|P|²` at one wavelength, µm, along `path = (u, v, w)`.
pub fn response(twin: &Twin<'_>, form: &FullWindow, path: DVec3, lambda_um: f64) -> f64 {
    let place = path.truncate() / lambda_um * DVec2::from(form.series.size_um);
    let nearest = (place + 0.5).floor();
    let tau = series_argument(twin, &form.series, &form.coat, path.z, lambda_um);
    let sharpness = window_sharpness(form, lambda_um);
    let radius = i64::from(form.window_radius);
    let mut amplitude = Complex64::default();
    let mut intensity = 0.0;
    for s in -radius..=radius {
        for r in -radius..=radius {
            let bin = nearest + DVec2::new(r as f64, s as f64);
            let tap = bin_amplitude(twin, &form.series, bin, tau) * window(place - bin, sharpness);
            amplitude += tap;
            intensity += tap.norm_sqr();
        }
    }
    let squared = match form.window.coherence {
        Coherence::Single => amplitude.norm_sqr(),
        Coherence::Ensemble => intensity,
    };
    series_scale(&form.series).powi(2) * squared
}
