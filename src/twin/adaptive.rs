//! The wavelength integral as a sum over bins in f64; see `templates/adaptive.wgsl`.
//!
//! `XYZ = C Σ_b ∫ |c_b(2π w t)|² exp(-|t·uv - f_b|²/σf²) W(t) dt`, `t = 1/λ`, `W` the colour weights with `dλ = λ² dt`. Exact
//! for an ensemble; for a single coherence patch as far as lobes of different bins do not overlap. `|c_b|²` is taken once
//! in a narrow lobe, at its mean wavenumber.

use glam::{DVec2, DVec3};

use crate::optics::{gain, path_difference};
use crate::plan::CoherenceScaling;
use crate::reference::Directions;
use crate::resolve::{BROADEST, LEAST_SQUARED, Lobes, OUTER_NODES, REACH_SIGMAS};

use super::Twin;
use super::series::{bin_amplitude, series_argument, series_scale};

/// Relative tristimulus values for one pair of directions.
pub fn tristimulus(twin: &Twin<'_>, Directions { wi, wr }: Directions) -> [f64; 3] {
    let factor = gain(wi, wr, twin.optics());
    if factor == 0.0 {
        return [0.0; 3];
    }
    let path = path_difference(wi, wr, twin.rotate_deg);
    (corridor(twin, path) * factor).to_array()
}

/// The sum over the bins of a strip along the segment, or over those about each node.
pub fn corridor(twin: &Twin<'_>, path: DVec3) -> DVec3 {
    let steep = path.y.abs() > path.x.abs();
    let turn = |v: DVec2| if steep { DVec2::new(v.y, v.x) } else { v };
    let uv = turn(path.truncate());
    let size_um = turn(DVec2::from(twin.resolved.patch_um));
    let range = wavenumbers(twin);
    let reach = REACH_SIGMAS * window_width(twin, range.y);
    let squared = uv.length_squared().max(LEAST_SQUARED);
    let slope = uv.y / if uv.x == 0.0 { 1.0 } else { uv.x };
    let ends = uv.x * range;
    let first = ((ends.min_element() - reach) * size_um.x).ceil();
    let last = ((ends.max_element() + reach) * size_um.x).floor();
    let breadth = lobe_breadth(twin, squared.sqrt(), range);
    let broad = breadth >= 1.0;
    let node_bins = twin.resolved.corridor.node_bins;
    let nodes = if twin.is_monochromatic() { 1 } else { twin.resolved.corridor.nodes };
    let count = if broad { f64::from(nodes * node_bins) } else { last - first + 1.0 };
    let half_width = if broad { reach } else { reach * (1.0 + slope * slope).sqrt() };
    let mut xyz = DVec3::ZERO;
    for i in 0..twin.resolved.corridor.majors {
        if f64::from(i) >= count {
            break;
        }
        let node = i / node_bins;
        let fixed = node_wavenumber(twin, node, range);
        let corner = ((fixed * uv.x - reach) * size_um.x).ceil() + f64::from(i - node * node_bins);
        let major = if broad { corner } else { first + f64::from(i) };
        let centre = if broad { fixed * uv.y } else { slope * major / size_um.x };
        let lowest = ((centre - half_width) * size_um.y).ceil();
        let highest = ((centre + half_width) * size_um.y).floor();
        for j in 0..twin.resolved.corridor.minors {
            let minor = lowest + f64::from(j);
            if minor > highest {
                break;
            }
            let place = DVec2::new(major, minor) / size_um;
            let wavenumber = if broad { fixed } else { lobe_centre(twin, place, uv, squared) };
            let share =
                window_share(twin, wavenumber * uv - place, uv, wavenumber, broad.then_some(range));
            if share > 0.0 {
                let light = lobe_light(twin, wavenumber, node, breadth, range);
                let bin = turn(DVec2::new(major, minor));
                let argument = series_argument(twin, path.z, light[3]);
                let amplitude = bin_amplitude(twin, bin, argument);
                xyz += share * amplitude.norm_sqr() * DVec3::new(light[0], light[1], light[2]);
            }
        }
    }
    let scale = if broad { 1.0 } else { window_width(twin, 1.0) / squared.sqrt() };
    scale * series_scale(twin).powi(2) * xyz
}

/// Width of the lobes of a direction over that of the broadest narrow ones.
fn lobe_breadth(twin: &Twin<'_>, length: f64, range: DVec2) -> f64 {
    if twin.is_monochromatic() {
        return 1.0;
    }
    window_width(twin, range.x) / (BROADEST * node_pace(twin, range) * length)
}

/// Wavenumber at which the segment passes a bin.
fn lobe_centre(twin: &Twin<'_>, place: DVec2, uv: DVec2, squared: f64) -> f64 {
    if twin.optics().coherence_scaling == CoherenceScaling::Wavelength {
        place.length_squared() / uv.dot(place).max(LEAST_SQUARED)
    } else {
        uv.dot(place) / squared
    }
}

/// X, Y, Z of a lobe and the wavelength at which its bin counts.
fn lobe_light(
    twin: &Twin<'_>,
    wavenumber: f64,
    node: u32,
    breadth: f64,
    range: DVec2,
) -> [f64; 4] {
    if breadth >= 1.0 {
        return twin.spectrum.load(i64::from(node), 0, 0);
    }
    let (columns, rows) = (twin.resolved.corridor.columns, twin.resolved.corridor.rows);
    let margin = 4.0 * node_pace(twin, range);
    let low = range.x - margin;
    let high = range.y + margin * window_width(twin, range.y) / window_width(twin, range.x);
    let column = ((wavenumber - low) / (high - low)).clamp(0.0, 1.0) * f64::from(columns - 1);
    let row = 2 + (breadth * f64::from(rows - 1) + 0.5) as i64;
    let index = (column as i64).min(i64::from(columns) - 2);
    let before = twin.spectrum.load(index, row, 0);
    let after = twin.spectrum.load(index + 1, row, 0);
    let part = column - index as f64;
    std::array::from_fn(|c| before[c] + part * (after[c] - before[c]))
}

/// Distance of the nodes.
fn node_pace(twin: &Twin<'_>, range: DVec2) -> f64 {
    (range.y - range.x) / (f64::from(twin.resolved.corridor.nodes) - 5.0)
}

/// Wavenumber of a node.
fn node_wavenumber(twin: &Twin<'_>, node: u32, range: DVec2) -> f64 {
    if twin.is_monochromatic() {
        return range.x;
    }
    range.x + (f64::from(node) - f64::from(OUTER_NODES)) * node_pace(twin, range)
}

/// Share of a bin's intensity that the window lets through at an offset from f; where the lobe is broad, `broad` the range,
/// within the narrower one of a node.
fn window_share(
    twin: &Twin<'_>,
    offset: DVec2,
    uv: DVec2,
    wavenumber: f64,
    broad: Option<DVec2>,
) -> f64 {
    let width = window_width(twin, wavenumber);
    let pace = match broad {
        Some(range) if !twin.is_monochromatic() => node_pace(twin, range),
        _ => 0.0,
    };
    let rest = width * width - pace * pace * uv.length_squared();
    let along = offset.dot(uv) * pace;
    let whole =
        offset.length_squared() / (width * width) + along * along / (rest * width * width);
    if whole < REACH_SIGMAS * REACH_SIGMAS { width / rest.sqrt() * (-whole).exp() } else { 0.0 }
}

/// Standard deviation of the window's spectrum, cycles per µm.
fn window_width(twin: &Twin<'_>, wavenumber: f64) -> f64 {
    Lobes::new(twin.variant, twin.resolved.patch_um).sigma_at(wavenumber)
}

/// Least and greatest wavenumber.
fn wavenumbers(twin: &Twin<'_>) -> DVec2 {
    if twin.is_monochromatic() {
        return DVec2::splat(1.0 / twin.spectrum.load(0, 0, 0)[3]);
    }
    let waves = &twin.variant.wavelengths;
    DVec2::new(1e3 / waves.max_nm, 1e3 / waves.min_nm)
}
