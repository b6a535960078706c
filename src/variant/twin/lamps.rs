//! Orders under lights with a size in f64; see `templates/lamps.wgsl`.

use std::f64::consts::FRAC_PI_2;

use glam::{BVec2, DVec2, DVec3, DVec4};

use crate::tables::orders::{CENTRE_NM, UNIT_NM};
use crate::variant::Orders;

use super::Twin;
use super::arrivals::{
    arrival, in_surface, normal_reflectance, order_frequency, order_share, polar, propagating,
};

mod caps;

pub use caps::Caps;

/// A cap of the sphere: its axis, and the square of the chord from the axis to its edge. For a hemisphere it is 2.
pub type Cap = (DVec3, f64);

/// Wavelength of a crossing that does not exist, µm.
const NEVER_UM: f64 = 1e9;

/// Square of the chord from the axis of a disc to its edge.
pub fn disc_chord_squared(radius_rad: f64) -> f64 {
    4.0 * (0.5 * radius_rad.clamp(1e-4, FRAC_PI_2)).sin().powi(2)
}

/// Unit vector to the inner side of an edge; the centre for an edge without length.
pub fn edge_normal(start: DVec3, end: DVec3, side: f64, centre: DVec3) -> DVec3 {
    let normal = side * start.cross(end);
    if normal.length_squared() < 1e-12 { centre } else { normal.normalize() }
}

/// First and last row of orders that may take light from within `reach` of a direction.
fn order_rows(form: &Orders, offset: DVec2, reach: f64) -> [i32; 2] {
    let limit = form.axes.bins.s_max as i32;
    orders_between(offset.y, reach, form.wavelengths_um(), form.sum.patch_um[1], limit)
}

/// The same for the orders of a row.
fn order_columns(form: &Orders, row: i32, offset: DVec2, reach: f64) -> [i32; 2] {
    let mut ends = form.wavelengths_um();
    if row != 0 {
        let side = |reach: f64| form.sum.patch_um[1] / f64::from(row) * (reach - offset.y);
        let sides = [side(-reach), side(reach)];
        ends = [ends[0].max(sides[0].min(sides[1])), ends[1].min(sides[0].max(sides[1]))];
    }
    if ends[0] > ends[1] {
        return [0, -1];
    }
    let limit = form.axes.bins.r_max as i32;
    orders_between(offset.x, reach, ends, form.sum.patch_um[0], limit)
}

fn orders_between(offset: f64, reach: f64, ends: [f64; 2], size_um: f64, limit: i32) -> [i32; 2] {
    let at = |reach: f64| ends.map(|end| size_um * (reach - offset) / end);
    let (low, high) = (at(-reach), at(reach));
    let most = f64::from(limit);
    let first = low[0].min(low[1]).ceil().clamp(-most, most + 1.0);
    let last = high[0].max(high[1]).floor().clamp(-most - 1.0, most);
    [first as i32, last as i32]
}

fn crossings(frequency: DVec2, wr: DVec3, (axis, chord_squared): Cap) -> DVec2 {
    let along = polar(frequency);
    let across = DVec2::new(-along.y, along.x);
    let of = |v: DVec3| DVec2::new(v.truncate().dot(along.truncate()), v.truncate().dot(across));
    let (start, lamp) = (-of(wr), of(axis));
    let apart = start.y - lamp.y;
    let sine_squared = chord_squared * (1.0 - 0.25 * chord_squared);
    let squared = sine_squared - apart * apart - chord_squared * start.y * lamp.y;
    if squared <= 0.0 {
        return DVec2::splat(NEVER_UM);
    }
    let root = squared.sqrt() * DVec2::new(-1.0, 1.0);
    let middle = 1.0 - 0.5 * chord_squared - start.y * lamp.y;
    let size_squared = (lamp.x * lamp.x + axis.z * axis.z).max(1e-12);
    let places = (lamp.x * middle + axis.z * root) / size_squared;
    let heights = axis.z * middle - lamp.x * root;
    let is_above = BVec2::new(heights.x > 0.0, heights.y > 0.0);
    DVec2::select(is_above, (start.x - places) / along.z, DVec2::splat(NEVER_UM))
}

fn within(wi: DVec3, (axis, chord_squared): Cap) -> bool {
    (wi - axis).length_squared() < chord_squared
}

fn order_colour(
    twin: &Twin<'_>,
    form: &Orders,
    order: DVec2,
    [from_um, to_um]: [f64; 2],
    colour: DVec3,
    wr: DVec3,
) -> DVec3 {
    let count = panel_count(form, order, [from_um, to_um], wr);
    let frequency = order_frequency(form, order);
    let mut xyz = DVec3::ZERO;
    let mut start_um = from_um;
    for panel in 1..=count {
        let part = f64::from(panel) / f64::from(count);
        let end_um = match panel < count {
            true => wavelength_between(frequency, [from_um, to_um], part, wr),
            false => to_um,
        };
        xyz += panel_colour(twin, form, order, [start_um, end_um], colour, wr);
        start_um = end_um;
    }
    xyz
}

/// Number of cubics for an order between two wavelengths.
pub fn panel_count(form: &Orders, order: DVec2, [from_um, to_um]: [f64; 2], wr: DVec3) -> u32 {
    let frequency = order_frequency(form, order);
    let (first, last) = (arrival(frequency, from_um, wr), arrival(frequency, to_um, wr));
    let middle_um = 0.5 * (from_um + to_um);
    let middle = arrival(frequency, middle_um, wr);
    let w = |wi: DVec3| -form.sum.coat.matter.path(wi, wr, 0.0).z;
    let turns = 2.0 * (w(first) / from_um - w(middle) / middle_um).abs();
    let columns = 0.5 * form.axes.phase_min_um() * f64::from(form.axes.columns) * turns;
    let needed = (columns / form.panel_columns()).max(first.distance(last) / form.panel_arc());
    let needed = needed.max(form.panel_pace * (1.0 / from_um - 1.0 / to_um));
    (needed as u32).min(form.panels() as u32 - 1) + 1
}

fn wavelength_between(frequency: DVec2, [from_um, to_um]: [f64; 2], part: f64, wr: DVec3) -> f64 {
    if frequency == DVec2::ZERO {
        return 1.0 / (1.0 / from_um + part * (1.0 / to_um - 1.0 / from_um));
    }
    let along = polar(frequency);
    let start = -wr.truncate().dot(along.truncate());
    let across = wr.y * along.x - wr.x * along.y;
    let half = (1.0 - across * across).max(1e-12).sqrt();
    let angle = |um: f64| ((start - um * along.z) / half).clamp(-1.0, 1.0).asin();
    let (first, last) = (angle(from_um), angle(to_um));
    let place = start - half * (first + part * (last - first)).sin();
    (place / along.z).clamp(from_um, to_um)
}

fn panel_colour(
    twin: &Twin<'_>,
    form: &Orders,
    order: DVec2,
    [from_um, to_um]: [f64; 2],
    colour: DVec3,
    wr: DVec3,
) -> DVec3 {
    let middle = 0.5 * (from_um + to_um);
    let half = 0.5 * (to_um - from_um);
    let (outer, inner) = (0.923_879_532_511_286_7, 0.382_683_432_365_089_8);
    let share = |place: f64| order_share(twin, form, order, middle + place * half, wr);
    let (highest, high, low, lowest) = (share(outer), share(inner), share(-inner), share(-outer));
    let mean = 0.25 * (highest + high + low + lowest);
    let linear = 0.5 * (outer * (highest - lowest) + inner * (high - low));
    let square = 0.125_f64.sqrt() * (highest - high - low + lowest);
    let cube = 0.5 * (inner * (highest - lowest) - outer * (high - low));
    let powers = DVec4::new(mean - square, linear - 3.0 * cube, 2.0 * square, 4.0 * cube);
    moments_between(twin, form, [from_um, to_um], powers, colour)
}

fn moments_between(
    twin: &Twin<'_>,
    form: &Orders,
    [from_um, to_um]: [f64; 2],
    powers: DVec4,
    colour: DVec3,
) -> DVec3 {
    let centre = (0.5 * (from_um + to_um) * 1e3 - CENTRE_NM) / UNIT_NM;
    let scale = 1.0 / (0.5e3 * (to_um - from_um) / UNIT_NM).max(1e-9);
    // of white light, of its red share and of its green one
    let shares = [colour.z, colour.x - colour.z, colour.y - colour.z];
    let mut sums = [DVec4::ZERO; 3];
    for (row, share) in (0..).step_by(4).zip(shares) {
        let moments = moments_of(twin, form, row, [from_um, to_um]);
        for (sum, moments) in sums.iter_mut().zip(moments) {
            *sum += share * moments;
        }
    }
    let channel = |sum: DVec4| {
        let [light, first, second, third] = sum.to_array();
        let linear = (first - centre * light) * scale;
        let square = (second - centre * (2.0 * first - centre * light)) * scale.powi(2);
        let cubic = third - 3.0 * centre * (second - centre * first) - centre.powi(3) * light;
        let cube = cubic * scale.powi(3);
        let most = light.max(0.0);
        let about = |moment: f64| moment.clamp(-most, most);
        powers.dot(DVec4::new(light, about(linear), about(square), about(cube)))
    };
    DVec3::from(sums.map(channel))
}

/// Moments of X, Y, Z between two wavelengths of the light of the table whose first row that is.
fn moments_of(twin: &Twin<'_>, form: &Orders, row: i64, [from_um, to_um]: [f64; 2]) -> [DVec4; 3] {
    let [before, after] = [from_um, to_um].map(|um| {
        let column = moment_column(form, um);
        let part = column_part(twin, form, um, column, row + 3).to_array();
        let powers = column_powers(form, column);
        [0, 1, 2].map(|c| moment(twin, column, row + c as i64) + part[c] * powers)
    });
    [0, 1, 2].map(|c| after[c] - before[c])
}

/// Place of a wavelength in columns of the table of moments.
fn moment_place(form: &Orders, lambda_um: f64) -> f64 {
    let [min_um, max_um] = form.wavelengths_um();
    (lambda_um - min_um) / (max_um - min_um) * (form.moment_columns() as f64 - 1.0)
}

fn moment_column(form: &Orders, lambda_um: f64) -> i64 {
    (moment_place(form, lambda_um) as i64).clamp(0, form.moment_columns() as i64 - 2)
}

fn column_part(twin: &Twin<'_>, form: &Orders, lambda_um: f64, column: i64, row: i64) -> DVec3 {
    let part = (moment_place(form, lambda_um) - column as f64).clamp(0.0, 1.0);
    part * DVec4::from(twin.coefficients.load(column, row, 0)).truncate()
}

fn column_powers(form: &Orders, column: i64) -> DVec4 {
    let [min_um, max_um] = form.wavelengths_um();
    let share = (column as f64 + 0.5) / (form.moment_columns() as f64 - 1.0);
    let t = ((min_um + share * (max_um - min_um)) * 1e3 - CENTRE_NM) / UNIT_NM;
    DVec4::new(1.0, t, t * t, t * t * t)
}

fn moment(twin: &Twin<'_>, column: i64, row: i64) -> DVec4 {
    DVec4::from(twin.coefficients.load(column, row, 0))
}
