//! Colours from a table over `(u, v, w)` in f64; see `templates/baked.wgsl`.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::field::reference::Directions;
use crate::tables::{BakedAxes, WideLevel, bilinear, octant};
use crate::variant::forms::{
    DISC_INNER, DISC_INNER_SHARE, DISC_LOBES, DISC_RING_VARIANCE, DISC_RINGS, DISC_SHARE,
};
use crate::variant::{Baked, Wide};

use super::Twin;

/// Relative tristimulus values for one pair of directions.
pub fn tristimulus(twin: &Twin<'_>, form: &Baked, Directions { wi, wr }: Directions) -> [f64; 3] {
    let matter = &form.coat.matter;
    let factor = matter.geometry(wi, wr);
    if factor == 0.0 {
        return [0.0; 3];
    }
    let xyz = colour_between(twin, &form.axes, matter.path(wi, wr, twin.rotate_deg));
    xyz.map(|c| factor / form.axes.colour_scale() * c)
}

/// The table, interpolated between two levels.
fn colour_between(twin: &Twin<'_>, axes: &BakedAxes, path: DVec3) -> [f64; 3] {
    let squared = path.truncate().length_squared();
    let turn = column_at(axes, path.truncate());
    let columns = f64::from(axes.page_columns());
    let page = (turn / columns).floor().min(f64::from(axes.pages - 1));
    let place = DVec2::new(turn - page * columns, row_at(axes, squared));
    let level = layer_share(axes, path.z, squared) * f64::from(axes.levels - 1);
    let below = level.floor().min(f64::from(axes.levels - 2));
    let layer = page as usize * axes.levels as usize + below as usize;
    let [a, b] = [layer, layer + 1].map(|layer| texel_at(twin, place, layer));
    std::array::from_fn(|c| a[c] + (level - below) * (b[c] - a[c]))
}

/// Position between the first and the last layer of w, 0 to 1.
pub fn layer_share(axes: &BakedAxes, w: f64, squared: f64) -> f64 {
    let share = ((w * w - axes.least_w_squared) / (4.0 - squared).max(1e-6)).clamp(0.0, 1.0);
    if axes.even_w { share.sqrt() } else { share }
}

/// Position of the angle of (u, v), in columns.
fn column_at(axes: &BakedAxes, uv: DVec2) -> f64 {
    let size = uv.abs();
    let octant = octant(size.min_element() / size.max_element().max(1e-20));
    let quadrant = if size.y > size.x { 2.0 - octant } else { octant };
    let upper = if uv.x < 0.0 { 4.0 - quadrant } else { quadrant };
    let turn = if uv.y < 0.0 { 8.0 - upper } else { upper };
    turn * f64::from(axes.columns / 8)
}

/// Position of the radius, in rows, from `|(u, v)|²`.
fn row_at(axes: &BakedAxes, squared: f64) -> f64 {
    let stretched = axes.stretch * axes.stretch * squared;
    let row = axes.pace * (stretched.sqrt() + (stretched + 1.0).sqrt()).ln();
    row.min(f64::from(axes.rows - 1))
}

/// A layer, interpolated between texels. Whole numbers are the centres of texels.
fn texel_at(twin: &Twin<'_>, place: DVec2, layer: usize) -> [f64; 4] {
    bilinear(twin.terms, place.to_array(), layer)
}

/// The same with lobes widened by a standard deviation in direction cosines. 0 without tables of wider lobes.
pub fn tristimulus_spread(
    twin: &Twin<'_>,
    form: &Baked,
    Directions { wi, wr }: Directions,
    spread: f64,
) -> [f64; 3] {
    let matter = &form.coat.matter;
    let factor = matter.geometry(wi, wr);
    let Some(wide) = form.wide.as_ref().filter(|_| factor != 0.0) else { return [0.0; 3] };
    let variance = 1.0 + (spread / wide.lobe_sigma).powi(2);
    let xyz = colour_widened(twin, form, wide, matter.path(wi, wr, twin.rotate_deg), variance);
    xyz.map(|c| factor / form.axes.colour_scale() * c)
}

/// Radiance under a disc of irradiance 1. 0 without tables of wider lobes.
pub fn tristimulus_disc(
    twin: &Twin<'_>,
    form: &Baked,
    axis: DVec3,
    radius_rad: f64,
    wr: DVec3,
) -> [f64; 3] {
    let Some(wide) = form.wide.as_ref().filter(|_| wr.z > 1e-6) else { return [0.0; 3] };
    let matter = &form.coat.matter;
    let narrowest = wide.lobe_sigma * wide.lobe_sigma;
    let disc = 0.25 * radius_rad.sin().powi(2);
    let own = disc * axis.z.max(0.01);
    let seen = |wi: DVec3, spread: f64| {
        DVec3::from(tristimulus_spread(twin, form, Directions { wi, wr }, spread))
    };
    let spread = |wi: DVec3| (DISC_SHARE * disc * wi.z - narrowest).max(0.0).sqrt();
    let xyz = if own <= narrowest {
        seen(axis, spread(axis))
    } else {
        let rest = (own - (DISC_SHARE * own).max(narrowest)).max(0.0);
        let size_rad = radius_rad * (rest / (DISC_RING_VARIANCE * own)).sqrt();
        let other = if axis.x.abs() > 0.7 { DVec3::Y } else { DVec3::X };
        let across = axis.cross(other).normalize();
        let along = axis.cross(across);
        let mirror = DVec3::new(-wr.x, -wr.y, wr.z);
        let path = matter.path(mirror, wr, twin.rotate_deg);
        let unit = 1.0 / form.axes.colour_scale();
        let image = unit * DVec3::from(colour_between(twin, &form.axes, path));
        let sharp = matter.geometry(mirror, wr) * disc_share(wide, (axis, radius_rad), mirror);
        let of = |index: usize| {
            let lobe = disc_lobe(index);
            let (away, turn) = (lobe.x * size_rad, DVec2::from_angle(lobe.y));
            let wi = away.cos() * axis + away.sin() * (turn.x * across + turn.y * along);
            let spread = spread(wi);
            let at = lobe_at(wide, wi.truncate() + wr.truncate(), spread);
            lobe.z * (seen(wi, spread) - matter.geometry(wi, wr) * at * image)
        };
        (sharp * image + (0..DISC_LOBES).map(of).sum::<DVec3>()).max(DVec3::ZERO)
    };
    let normal = form.coat.matter.normal_reflectance();
    let light = 2.0 / (1.0 + radius_rad.cos());
    (light * normal / (TAU * narrowest) * xyz).to_array()
}

/// Mean over a disc of the narrowest lobe with the peak 1 about a direction, with a sharp edge.
fn disc_share(wide: &Wide, (axis, radius_rad): (DVec3, f64), direction: DVec3) -> f64 {
    let beyond = direction.dot(axis).clamp(-1.0, 1.0).acos() - radius_rad;
    let inside = 0.5 - 0.5 * (6.0 / wide.lobe_sigma * beyond * direction.z.sqrt()).tanh();
    let size = 0.5 * radius_rad.sin().powi(2) * direction.z / wide.lobe_sigma.powi(2);
    inside * (1.0 - (-size).exp()) / size.max(1e-6)
}

/// A widened lobe with the peak 1 at a distance in direction cosines.
fn lobe_at(wide: &Wide, distance: DVec2, spread: f64) -> f64 {
    let narrowest = wide.lobe_sigma * wide.lobe_sigma;
    let wanted = (1.0 + spread * spread / narrowest).min(wide.widest());
    let (_, own) = level_below(wide, wanted);
    let squared = 0.5 * distance.length_squared() / (narrowest * own);
    let (narrower, wider) = ((-squared).exp(), (-squared / wide.ratio()).exp() / wide.ratio());
    (narrower + wider_share(wide, wanted / own) * (wider - narrower)) / own
}

/// A lobe of a disc: its distance from the middle relative to the radius of the disc, its angle around it, its share.
fn disc_lobe(index: usize) -> DVec3 {
    let (first, count, ring, share) = if index < DISC_INNER {
        (0, DISC_INNER, DISC_RINGS[0], DISC_INNER_SHARE)
    } else {
        (DISC_INNER, DISC_LOBES - DISC_INNER, DISC_RINGS[1], 1.0 - DISC_INNER_SHARE)
    };
    let count = count as f64;
    DVec3::new(ring, TAU / count * (index - first) as f64, share / count)
}

/// Colours of lobes with a multiple of the narrowest variance, between the two nearest levels.
fn colour_widened(
    twin: &Twin<'_>,
    form: &Baked,
    wide: &Wide,
    path: DVec3,
    variance: f64,
) -> [f64; 3] {
    let wanted = variance.clamp(1.0, wide.widest());
    let (level, own) = level_below(wide, wanted);
    let of = |level: usize| match level.checked_sub(1).and_then(|i| wide.axes.levels.get(i)) {
        Some(level) => wide_between(twin, level, path),
        None => colour_between(twin, &form.axes, path),
    };
    let (narrower, wider) = (of(level), of(level + 1));
    let share = wider_share(wide, wanted / own);
    let mixed = |c| narrower[c] + share * (wider[c] / wide.ratio() - narrower[c]);
    std::array::from_fn(|c| mixed(c) / own)
}

/// The widest level, except the last, whose lobes are no wider than `wanted`, and their variance.
fn level_below(wide: &Wide, wanted: f64) -> (usize, f64) {
    let (mut level, mut own) = (0, 1.0);
    for next in 1..wide.axes.levels.len() {
        if wanted >= own * wide.ratio() {
            own *= wide.ratio();
            level = next;
        }
    }
    (level, own)
}

/// Share of the wider of two levels.
fn wider_share(wide: &Wide, variance: f64) -> f64 {
    (variance - 1.0) / (wide.ratio() - 1.0)
}

/// A table of wider lobes, interpolated between two layers.
fn wide_between(twin: &Twin<'_>, level: &WideLevel, path: DVec3) -> [f64; 3] {
    let WideLevel { axes, place: corner, .. } = level;
    let squared = path.truncate().length_squared();
    let turn = column_at(axes, path.truncate());
    let columns = f64::from(axes.page_columns());
    let page = (turn / columns).floor().min(f64::from(axes.pages - 1));
    let [left, top] = corner.map(f64::from);
    let first = DVec2::new(left, top + page * f64::from(axes.rows));
    let part = DVec2::new(turn - page * columns, row_at(axes, squared));
    let layer = layer_share(axes, path.z, squared) * f64::from(axes.levels - 1);
    let below = layer.floor().min(f64::from(axes.levels - 2));
    let at = |layer: usize| wide_texel_at(twin, first, part, layer);
    let [a, b] = [below as usize, below as usize + 1].map(at);
    std::array::from_fn(|c| a[c] + (layer - below) * (b[c] - a[c]))
}

/// A layer of the tables of wider lobes, interpolated between texels.
fn wide_texel_at(twin: &Twin<'_>, first: DVec2, part: DVec2, layer: usize) -> [f64; 4] {
    bilinear(twin.coefficients, (first + part).to_array(), layer)
}
