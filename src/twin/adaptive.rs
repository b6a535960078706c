//! The wavelength integral as a sum over bins in f64; see `templates/adaptive.wgsl`.
//!
//! `XYZ = C Σ_b ∫ |c_b(2π w t)|² exp(-|t·uv - f_b|²/σf²) W(t) dt`, `t = 1/λ`, `W` the colour weights with `dλ = λ² dt`. Exact
//! for an ensemble; for a single coherence patch as far as lobes of different bins do not overlap. Each lobe is a
//! midpoint rule over ±4 standard deviations, cut to the range; steps of one standard deviation integrate a whole
//! Gaussian to 1e-8.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DVec2, DVec3};

use crate::optics::{gain, path_difference};
use crate::plan::CoherenceScaling;
use crate::reference::Directions;
use crate::resolve::{LEAST_SQUARED, LOBE_NODES, Lobes, REACH_SIGMAS, WHOLE_PANELS};

use super::Twin;
use super::series::{bin_amplitude, series_argument, series_scale};
use super::window::{window, window_sharpness};

/// Relative tristimulus values for one pair of directions.
pub fn tristimulus(twin: &Twin<'_>, Directions { wi, wr }: Directions) -> [f64; 3] {
    let factor = gain(wi, wr, twin.optics());
    if factor == 0.0 {
        return [0.0; 3];
    }
    let path = path_difference(wi, wr, twin.rotate_deg);
    let monochromatic = twin.spectrum.width == 1;
    corridor(twin, path, wavenumbers(twin), |bin, range| {
        if monochromatic {
            let [x, y, z, lambda_um] = twin.spectrum.load(0, 0, 0);
            (DVec3::new(x, y, z) * intensity(twin, bin, path, lambda_um)).to_array()
        } else {
            lobe(twin, bin, path, range)
        }
    })
    .map(|c| c * factor)
}

/// A bin's intensity under the window at one wavelength.
pub fn intensity(twin: &Twin<'_>, bin: DVec2, path: DVec3, lambda_um: f64) -> f64 {
    let amplitude = bin_amplitude(twin, bin, series_argument(twin, path.z, lambda_um));
    amplitude.norm_sqr() * window_share(twin, bin, path.truncate(), 1.0 / lambda_um)
}

/// The sum over the bins of a strip along the segment, whichever axis it is steeper to inside.
pub fn corridor(
    twin: &Twin<'_>,
    path: DVec3,
    range: DVec2,
    lobe: impl Fn(DVec2, DVec2) -> [f64; 3],
) -> [f64; 3] {
    let steep = path.y.abs() > path.x.abs();
    let turn = |v: DVec2| if steep { DVec2::new(v.y, v.x) } else { v };
    let along = turn(path.truncate());
    let size_um = turn(DVec2::from(twin.resolved.patch_um));
    let slope = along.y / if along.x == 0.0 { 1.0 } else { along.x };
    let reach = REACH_SIGMAS * window_width(twin, range.y);
    let half_width = reach * (1.0 + slope * slope).sqrt();
    let ends = along.x * range;
    let first = ((ends.min_element() - reach) * size_um.x).ceil();
    let last = ((ends.max_element() + reach) * size_um.x).floor();
    let mut xyz = DVec3::ZERO;
    for i in 0..twin.resolved.corridor.majors {
        let major = first + f64::from(i);
        if major > last {
            break;
        }
        let centre = slope * major / size_um.x;
        let lowest = ((centre - half_width) * size_um.y).ceil();
        let highest = ((centre + half_width) * size_um.y).floor();
        for j in 0..twin.resolved.corridor.minors {
            let minor = lowest + f64::from(j);
            if minor > highest {
                break;
            }
            xyz += DVec3::from(lobe(turn(DVec2::new(major, minor)), range));
        }
    }
    (xyz * series_scale(twin).powi(2)).to_array()
}

/// What one bin adds while the segment crosses its lobe.
fn lobe(twin: &Twin<'_>, bin: DVec2, path: DVec3, range: DVec2) -> [f64; 3] {
    let uv = path.truncate();
    let span = lobe_span(twin, bin / DVec2::from(twin.resolved.patch_um), uv, range);
    if span.x >= span.y {
        return [0.0; 3];
    }
    let most = f64::from(twin.resolved.corridor.panels);
    let share = (span.y - span.x) / (range.y - range.x) * most;
    let panels = if share < WHOLE_PANELS { 1.0 } else { share.ceil().min(most) };
    let pace = (span.y - span.x) / (panels * f64::from(LOBE_NODES));
    let mut xyz = DVec3::ZERO;
    for panel in 0..panels as u32 {
        let mut weight = DVec3::ZERO;
        let mut moment = 0.0;
        for node in 0..LOBE_NODES {
            let wavenumber = span.x + (f64::from(panel * LOBE_NODES + node) + 0.5) * pace;
            let light =
                window_share(twin, bin, uv, wavenumber) * colour_weights(twin, wavenumber, range);
            weight += light;
            moment += wavenumber * light.element_sum();
        }
        let total = weight.element_sum();
        if total > 0.0 {
            let argument = series_argument(twin, path.z, total / moment);
            xyz += bin_amplitude(twin, bin, argument).norm_sqr() * weight;
        }
    }
    (pace * xyz).to_array()
}

/// Wavenumbers within reach of a bin, cut to the range.
fn lobe_span(twin: &Twin<'_>, place: DVec2, uv: DVec2, range: DVec2) -> DVec2 {
    let half_width = FRAC_1_SQRT_2 * REACH_SIGMAS * window_width(twin, 1.0 / 0.55);
    if twin.optics().coherence_scaling == CoherenceScaling::Wavelength {
        let squared = place.length_squared().max(LEAST_SQUARED);
        let centre_um = uv.dot(place) / squared;
        let half_um = 0.55 * half_width / squared.sqrt();
        let low_um = (centre_um - half_um).max(1.0 / range.y);
        let high_um = (centre_um + half_um).min(1.0 / range.x);
        return if low_um < high_um {
            DVec2::new(1.0 / high_um, 1.0 / low_um)
        } else {
            DVec2::new(1.0, 0.0)
        };
    }
    let squared = uv.length_squared().max(LEAST_SQUARED);
    let centre = uv.dot(place) / squared;
    let half_span = half_width / squared.sqrt();
    DVec2::new((centre - half_span).max(range.x), (centre + half_span).min(range.y))
}

/// X, Y, Z per 1/µm at a wavenumber.
fn colour_weights(twin: &Twin<'_>, wavenumber: f64, range: DVec2) -> DVec3 {
    let last = twin.spectrum.width as i64 - 1;
    let place = (wavenumber - range.x) / (range.y - range.x) * last as f64;
    let index = (place as i64).clamp(0, last - 1);
    let texel = |i: i64| {
        let [x, y, z, _] = twin.spectrum.load(i, 0, 0);
        DVec3::new(x, y, z)
    };
    texel(index).lerp(texel(index + 1), place - index as f64)
}

/// Share of a bin's intensity that the window lets through at `f = uv·t`.
fn window_share(twin: &Twin<'_>, bin: DVec2, uv: DVec2, wavenumber: f64) -> f64 {
    let place = wavenumber * uv * DVec2::from(twin.resolved.patch_um);
    window(place - bin, window_sharpness(twin, 1.0 / wavenumber)).powi(2)
}

/// Standard deviation of the window's spectrum, cycles per µm.
fn window_width(twin: &Twin<'_>, wavenumber: f64) -> f64 {
    Lobes::new(twin.variant, twin.resolved.patch_um).sigma_at(wavenumber)
}

/// Least and greatest wavenumber.
fn wavenumbers(twin: &Twin<'_>) -> DVec2 {
    if twin.spectrum.width == 1 {
        return DVec2::splat(1.0 / twin.spectrum.load(0, 0, 0)[3]);
    }
    let waves = &twin.variant.wavelengths;
    DVec2::new(1e3 / waves.max_nm, 1e3 / waves.min_nm)
}
