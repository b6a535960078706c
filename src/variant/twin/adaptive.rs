//! The wavelength integral as a sum over bins in f64; see `templates/adaptive.wgsl`.
//!
//! `XYZ = C Σ_b ∫ |c_b(2π w t)|² exp(-|t·uv - f_b|²/σf²) W(t) dt`, `t = 1/λ`, `W` the colour weights with `dλ = λ² dt`.
//! This is exact for an ensemble. For a single coherence patch it holds as far as lobes of different bins do not
//! overlap. In a narrow lobe, `|c_b|²` is evaluated once, at the mean wavenumber, or twice.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DVec2, DVec3};

use crate::field::reference::Directions;
use crate::optics::Facing;
use crate::tables::{BROADEST, LobeGeometry, MIN_SQUARED, OUTER_NODES, REACH_SIGMAS, Series};
use crate::variant::{LobeSum, Orders};

use super::Twin;
use super::bins::bin_amplitude;
use super::efficiencies::efficiency;
use super::matter::{dispersed, reflectance};
use super::series::{series_argument, series_scale};

/// What the intensities of bins are computed from.
#[derive(Clone, Copy)]
pub enum Bins<'a> {
    /// A series of terms.
    Series(&'a Series),
    /// A table of efficiencies.
    Efficiencies(&'a Orders),
}

/// Relative tristimulus values for one pair of directions.
pub fn tristimulus(
    twin: &Twin<'_>,
    form: &LobeSum,
    bins: Bins<'_>,
    Directions { wi, wr }: Directions,
) -> [f64; 3] {
    let matter = &form.coat.matter;
    let factor = matter.geometry(wi, wr);
    if factor == 0.0 {
        return [0.0; 3];
    }
    let path = matter.path(wi, wr, twin.rotate_deg);
    (corridor(twin, form, bins, path, Some(matter.facing_of(wi, wr))) * factor).to_array()
}

/// The sum over the bins of a strip along the segment, or over the bins about each node. Without `facing` the reflectance is
/// left out.
pub fn corridor(
    twin: &Twin<'_>,
    form: &LobeSum,
    bins: Bins<'_>,
    path: DVec3,
    facing: Option<Facing>,
) -> DVec3 {
    let steep = path.y.abs() > path.x.abs();
    let turn = |v: DVec2| if steep { DVec2::new(v.y, v.x) } else { v };
    let uv = turn(path.truncate());
    let size_um = turn(DVec2::from(form.patch_um));
    let range = wavenumbers(twin, form);
    let reach = REACH_SIGMAS * window_width(form, range.y);
    let squared = uv.length_squared().max(MIN_SQUARED);
    let slope = uv.y / if uv.x == 0.0 { 1.0 } else { uv.x };
    let ends = uv.x * range;
    let first = ((ends.min_element() - reach) * size_um.x).ceil();
    let last = ((ends.max_element() + reach) * size_um.x).floor();
    let breadth = lobe_breadth(twin, form, squared.sqrt(), range);
    let broad = breadth >= 1.0;
    let node_bins = form.corridor.node_bins;
    let nodes = if twin.is_monochromatic() { 1 } else { form.corridor.nodes };
    let minors = form.corridor.minors;
    let count =
        if broad { nodes * node_bins } else { (last - first).max(-1.0) as u32 + 1 } * minors;
    let half_width = if broad { reach } else { reach * (1.0 + slope * slope).sqrt() };
    let pace = if broad { node_pace(twin, form, range) } else { 0.0 };
    let row = lobe_row(form, breadth);
    let mut xyz = DVec3::ZERO;
    for index in 0..count.min(form.corridor.candidates) {
        let line = index / minors;
        let node = line / node_bins;
        let fixed = node_wavenumber(twin, form, node, range);
        let corner =
            ((fixed * uv.x - reach) * size_um.x).ceil() + f64::from(line - node * node_bins);
        let major = if broad { corner } else { first + f64::from(line) };
        let centre = if broad { fixed * uv.y } else { slope * major / size_um.x };
        let lowest = ((centre - half_width) * size_um.y).ceil();
        let bin = DVec2::new(major, lowest + f64::from(index - line * minors));
        let place = bin / size_um;
        let wavenumber = if broad { fixed } else { lobe_centre(form, place, uv, squared) };
        let width = window_width(form, wavenumber);
        let sharpness = lobe_sharpness(width, squared, pace);
        let exponent = window_exponent(wavenumber * uv - place, uv, sharpness);
        if exponent < REACH_SIGMAS * REACH_SIGMAS {
            let share = window_share(exponent, squared, width, pace);
            for side in 0..lobe_halves(form, row) {
                let light = lobe_light(twin, form, wavenumber, node, row, side, range);
                let colour = DVec3::new(light[0], light[1], light[2]);
                let squared = match bins {
                    Bins::Efficiencies(orders) => {
                        let turns = dispersed(twin, &form.coat, path.z, light[3]) / light[3];
                        efficiency(twin, orders, turn(bin), turns)
                    }
                    Bins::Series(series) => {
                        let coat = &form.coat;
                        let argument = series_argument(twin, series, coat, path.z, light[3]);
                        let amplitude = bin_amplitude(twin, series, turn(bin), argument);
                        amplitude.norm_sqr() * series_scale(series).powi(2)
                    }
                };
                let reflected =
                    facing.map_or(1.0, |facing| reflectance(twin, &form.coat, light[3], facing));
                xyz += share * squared * reflected * colour;
            }
        }
    }
    let scale = if broad { 1.0 } else { window_width(form, 1.0) / squared.sqrt() };
    scale * xyz
}

/// Width of the lobes of a direction, relative to the broadest narrow lobe.
fn lobe_breadth(twin: &Twin<'_>, form: &LobeSum, length: f64, range: DVec2) -> f64 {
    if twin.is_monochromatic() {
        return 1.0;
    }
    window_width(form, range.x) / (BROADEST * node_pace(twin, form, range) * length)
}

/// Wavenumber at which the segment passes closest to a bin.
fn lobe_centre(form: &LobeSum, place: DVec2, uv: DVec2, squared: f64) -> f64 {
    if form.geometry.scales {
        place.length_squared() / uv.dot(place).max(MIN_SQUARED)
    } else {
        uv.dot(place) / squared
    }
}

/// Row of the table for narrow lobes of this width. `None` for broad lobes.
fn lobe_row(form: &LobeSum, breadth: f64) -> Option<u32> {
    let last = f64::from(form.corridor.rows) - 1.0;
    (breadth < 1.0).then_some((breadth * last + 0.5) as u32)
}

/// Number of wavelengths at which a lobe's bin is evaluated.
fn lobe_halves(form: &LobeSum, row: Option<u32>) -> u32 {
    let halved = row.is_some_and(|row| LobeGeometry::is_halved(row, form.corridor.rows));
    if halved { 2 } else { 1 }
}

/// X, Y, Z of a lobe or of one of its halves, and the wavelength at which its bin is evaluated.
fn lobe_light(
    twin: &Twin<'_>,
    form: &LobeSum,
    wavenumber: f64,
    node: u32,
    row: Option<u32>,
    side: u32,
    range: DVec2,
) -> [f64; 4] {
    let Some(row) = row else { return twin.spectrum.load(i64::from(node), 0, 0) };
    let (columns, rows) = (form.corridor.columns, form.corridor.rows);
    let margin = FRAC_1_SQRT_2 * REACH_SIGMAS * BROADEST * node_pace(twin, form, range);
    let low = range.x - margin;
    let high = range.y + margin * window_width(form, range.y) / window_width(form, range.x);
    let column = ((wavenumber - low) / (high - low)).clamp(0.0, 1.0) * f64::from(columns - 1);
    let line = i64::from(2 + row + side * rows);
    let index = (column as i64).min(i64::from(columns) - 2);
    let before = twin.spectrum.load(index, line, 0);
    let after = twin.spectrum.load(index + 1, line, 0);
    let part = column - index as f64;
    std::array::from_fn(|c| before[c] + part * (after[c] - before[c]))
}

/// Distance between nodes.
fn node_pace(twin: &Twin<'_>, form: &LobeSum, range: DVec2) -> f64 {
    if twin.is_monochromatic() {
        return 0.0;
    }
    (range.y - range.x) / (f64::from(form.corridor.nodes) - 1.0 - 2.0 * f64::from(OUTER_NODES))
}

/// Wavenumber of a node.
fn node_wavenumber(twin: &Twin<'_>, form: &LobeSum, node: u32, range: DVec2) -> f64 {
    if twin.is_monochromatic() {
        return range.x;
    }
    range.x + (f64::from(node) - f64::from(OUTER_NODES)) * node_pace(twin, form, range)
}

/// Factors of the exponent: `1/σf²`, and the number that is added along the segment within the lobe of a node.
fn lobe_sharpness(width: f64, squared: f64, pace: f64) -> DVec2 {
    let rest = width * width - pace * pace * squared;
    DVec2::new(1.0, pace * pace / rest) / (width * width)
}

/// Minus the logarithm of the window's weight for a bin's intensity, at an offset from f.
fn window_exponent(offset: DVec2, uv: DVec2, sharpness: DVec2) -> f64 {
    sharpness.x * offset.length_squared() + sharpness.y * offset.dot(uv).powi(2)
}

/// The window's weight for a bin's intensity.
fn window_share(exponent: f64, squared: f64, width: f64, pace: f64) -> f64 {
    width / (width * width - pace * pace * squared).sqrt() * (-exponent).exp()
}

/// Standard deviation of the window's spectrum, cycles per µm.
fn window_width(form: &LobeSum, wavenumber: f64) -> f64 {
    form.geometry.sigma_at(wavenumber)
}

/// Minimum and maximum wavenumber.
fn wavenumbers(twin: &Twin<'_>, form: &LobeSum) -> DVec2 {
    if twin.is_monochromatic() {
        return DVec2::splat(1.0 / twin.spectrum.load(0, 0, 0)[3]);
    }
    DVec2::from(form.geometry.range)
}
