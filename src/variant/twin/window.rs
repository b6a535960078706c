//! The spectrum of the coherence window in f64; see `templates/window.wgsl`.

use std::f64::consts::PI;

use glam::DVec2;

use crate::optics;
use crate::variant::FullWindow;

/// `1/(2 σ²)` of the window on each axis, in bins.
pub fn window_sharpness(form: &FullWindow, lambda_um: f64) -> DVec2 {
    let sigma_um = optics::window_sigma_um(form.window, lambda_um * 1e3);
    let turns = 2.0 * PI * sigma_um / DVec2::from(form.series.size_um);
    0.5 * turns * turns
}

/// Weight of the coherence window at an offset in bins, peak 1.
pub fn window(offset: DVec2, sharpness: DVec2) -> f64 {
    (-(offset * offset).dot(sharpness)).exp()
}
