//! Orders under lights with a size in f64; see `templates/lamps.wgsl`.

use glam::{BVec2, DVec2, DVec3, DVec4};

use crate::optics::{gain, normal_reflectance};
use crate::tables::orders::{CENTRE_NM, UNIT_NM};
use crate::variant::Orders;
use crate::variant::forms::PANEL_ARC;

use super::Twin;
use super::efficiencies::efficiency;

/// A cap of the sphere: its axis, and the square of the chord from the axis to its edge. For a hemisphere it is 2.
pub type Cap = (DVec3, f64);

/// Wavelength of a crossing that does not exist, µm.
const NEVER_UM: f64 = 1e9;

/// X, Y, Z under radiance 1 from the intersection of caps. `bounds`: a cap that contains it.
pub fn under_caps(twin: &Twin<'_>, form: &Orders, caps: &[Cap], bounds: Cap, wr: DVec3) -> DVec3 {
    if !(wr.z > 1e-6) {
        return DVec3::ZERO;
    }
    let turned: Vec<Cap> =
        caps.iter().map(|(axis, chord)| (in_surface(twin, *axis), *chord)).collect();
    let viewer = in_surface(twin, wr);
    let bounds = (in_surface(twin, bounds.0), bounds.1);
    let mut xyz = DVec3::ZERO;
    visit(form, &turned, bounds, viewer, &mut |order, range_um| {
        xyz += order_colour(twin, form, order, range_um, viewer);
    });
    normal_reflectance(twin.optics.refractive_index) * xyz
}

/// Calls `lit` with each order that takes light from within all caps, and the range of wavelengths in µm. All directions are
/// in the frame of the surface.
pub fn visit(
    form: &Orders,
    caps: &[Cap],
    (axis, chord_squared): Cap,
    wr: DVec3,
    lit: &mut dyn FnMut(DVec2, [f64; 2]),
) {
    let offset = (axis + wr).truncate();
    let reach = chord_squared.sqrt();
    let rows = order_rows(form, offset, reach);
    for row in rows[0]..=rows[1] {
        let columns = order_columns(form, row, offset, reach);
        for column in columns[0]..=columns[1] {
            let order = DVec2::new(f64::from(column), f64::from(row));
            let frequency = order_frequency(form, order);
            let [mut from_um, last_um] = propagating(form, frequency, wr);
            let mut edges: Vec<f64> = caps
                .iter()
                .flat_map(|cap| crossings(frequency, wr, *cap).to_array())
                .filter(|edge| *edge > from_um && *edge < last_um)
                .collect();
            edges.sort_by(f64::total_cmp);
            edges.push(last_um);
            for to_um in edges {
                if from_um >= to_um {
                    continue;
                }
                let wi = arrival(frequency, 0.5 * (from_um + to_um), wr);
                if caps.iter().all(|cap| within(wi, *cap)) {
                    lit(order, [from_um, to_um]);
                }
                from_um = to_um;
            }
        }
    }
}

/// Direction in the frame of the surface.
fn in_surface(twin: &Twin<'_>, v: DVec3) -> DVec3 {
    if twin.rotate_deg == 0.0 {
        return v;
    }
    let (sin, cos) = twin.rotate_deg.to_radians().sin_cos();
    DVec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
}

/// First and last row of orders that may take light from within `reach` of a direction.
fn order_rows(form: &Orders, offset: DVec2, reach: f64) -> [i32; 2] {
    let limit = form.axes.bins.s_max as i32;
    orders_between(offset.y, reach, wavelengths(form), form.sum.patch_um[1], limit)
}

/// The same for the orders of a row.
fn order_columns(form: &Orders, row: i32, offset: DVec2, reach: f64) -> [i32; 2] {
    let mut ends = wavelengths(form);
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

/// Shortest and longest wavelength, µm.
fn wavelengths(form: &Orders) -> [f64; 2] {
    form.sum.range_nm.map(|nm| nm * 1e-3)
}

fn order_frequency(form: &Orders, order: DVec2) -> DVec2 {
    order / DVec2::from(form.sum.patch_um)
}

/// Length and direction of a frequency.
fn polar(frequency: DVec2) -> DVec3 {
    let size = frequency.length().max(1e-9);
    (frequency / size).extend(size)
}

fn arrival(frequency: DVec2, lambda_um: f64, wr: DVec3) -> DVec3 {
    let plane = -wr.truncate() - lambda_um * frequency;
    plane.extend((1.0 - plane.length_squared()).max(0.0).sqrt())
}

fn propagating(form: &Orders, frequency: DVec2, wr: DVec3) -> [f64; 2] {
    let along = polar(frequency);
    let start = -wr.truncate().dot(along.truncate());
    let across = wr.y * along.x - wr.x * along.y;
    let half = (1.0 - across * across).max(0.0).sqrt();
    let [min_um, max_um] = wavelengths(form);
    [min_um.max((start - half) / along.z), max_um.min((start + half) / along.z)]
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
        xyz += panel_colour(twin, form, order, [start_um, end_um], wr);
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
    let turns = 2.0 * ((first.z + wr.z) / from_um - (middle.z + wr.z) / middle_um).abs();
    let columns = 0.5 * form.axes.min_um * f64::from(form.axes.columns) * turns;
    let needed = (columns / form.panel_columns()).max(first.distance(last) / PANEL_ARC);
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
    moments_between(twin, form, [from_um, to_um], powers)
}

fn moments_between(
    twin: &Twin<'_>,
    form: &Orders,
    [from_um, to_um]: [f64; 2],
    powers: DVec4,
) -> DVec3 {
    let centre = (0.5 * (from_um + to_um) * 1e3 - CENTRE_NM) / UNIT_NM;
    let scale = 1.0 / (0.5e3 * (to_um - from_um) / UNIT_NM).max(1e-9);
    let channel = |row: i64| {
        let [light, first, second, third] =
            (moment_at(twin, form, to_um, row) - moment_at(twin, form, from_um, row)).to_array();
        let linear = (first - centre * light) * scale;
        let square = (second - centre * (2.0 * first - centre * light)) * scale.powi(2);
        let cubic = third - 3.0 * centre * (second - centre * first) - centre.powi(3) * light;
        let cube = cubic * scale.powi(3);
        let most = light.max(0.0);
        let about = |moment: f64| moment.clamp(-most, most);
        powers.dot(DVec4::new(light, about(linear), about(square), about(cube)))
    };
    DVec3::new(channel(0), channel(1), channel(2))
}

fn moment_at(twin: &Twin<'_>, form: &Orders, lambda_um: f64, row: i64) -> DVec4 {
    let [min_um, max_um] = wavelengths(form);
    let last = form.moment_columns() as f64 - 1.0;
    let place = ((lambda_um - min_um) / (max_um - min_um)).clamp(0.0, 1.0) * last;
    let column = (place as i64).min(form.moment_columns() as i64 - 2);
    let load = |column: i64| DVec4::from(twin.coefficients.load(column, row, 0));
    let (before, after) = (load(column), load(column + 1));
    before + (place - column as f64) * (after - before)
}

fn order_share(twin: &Twin<'_>, form: &Orders, order: DVec2, lambda_um: f64, wr: DVec3) -> f64 {
    let wi = arrival(order_frequency(form, order), lambda_um, wr);
    let turns = -(wi.z + wr.z) / lambda_um;
    gain(wi, wr, twin.optics) / wi.z.max(1e-6) * efficiency(twin, form, order, turns)
}
