//! Random paths over `(u, v)` in f64; see `templates/colour_path.wgsl`.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, DVec4};

use crate::field::reference::Directions;
use crate::tables::paths::{PATH_LEVELS, path_columns};
use crate::variant::Baked;

use super::Twin;
use super::baked::tristimulus;

/// A path from three random numbers, of which it uses two: the direction to the light, and 0.
pub fn diffraction_path(twin: &Twin<'_>, wr: DVec3, random: DVec3) -> DVec4 {
    let (mut low, mut high) = ([0.0; 2], [1.0; 2]);
    let mut rest = [random.x, random.y].map(|number| number.clamp(0.0, 0.999_999_9));
    let mut node = 1;
    for _ in 0..PATH_LEVELS {
        let (axis, place, below) = path_half(twin, node);
        let is_above = rest[axis] >= below;
        if is_above {
            rest[axis] = (rest[axis] - below) / (1.0 - below).max(1e-20);
            low[axis] = place;
        } else {
            rest[axis] /= below.max(1e-20);
            high[axis] = place;
        }
        node = 2 * node + usize::from(is_above);
    }
    let [turn, area] = [0, 1].map(|axis| low[axis] + rest[axis] * (high[axis] - low[axis]));
    let uv = 2.0 * area.sqrt() * DVec2::from_angle(TAU * (turn - 0.5));
    let plane = -wr.truncate() - DVec2::from_angle(twin.rotate_deg.to_radians()).rotate(uv);
    plane.extend((1.0 - plane.length_squared()).max(0.0).sqrt()).extend(0.0)
}

/// X, Y, Z of a path's weight.
pub fn tristimulus_weight(twin: &Twin<'_>, form: &Baked, wr: DVec3, path: DVec4) -> [f64; 3] {
    if wr.z <= 1e-6 || path.z <= 1e-6 {
        return [0.0; 3];
    }
    let wi = path.truncate();
    let uv = form.coat.matter.path(wi, wr, twin.rotate_deg).truncate();
    let chance = path_density(twin, uv) * wi.z;
    tristimulus(twin, form, Directions { wi, wr }).map(|c| form.radiance_scale / chance * c)
}

fn path_density(twin: &Twin<'_>, uv: DVec2) -> f64 {
    let places = [uv.y.atan2(uv.x) / TAU + 0.5, 0.25 * uv.length_squared()];
    let (mut low, mut high) = ([0.0; 2], [1.0; 2]);
    let (mut chance, mut node) = (1.0, 1);
    for _ in 0..PATH_LEVELS {
        let (axis, place, below) = path_half(twin, node);
        let is_above = places[axis] >= place;
        if is_above {
            (chance, low[axis]) = (chance * (1.0 - below), place);
        } else {
            (chance, high[axis]) = (chance * below, place);
        }
        node = 2 * node + usize::from(is_above);
    }
    chance / (4.0 * PI * (high[0] - low[0]) * (high[1] - low[1])).max(1e-20)
}

/// Axis, place and probability of the half below.
fn path_half(twin: &Twin<'_>, node: usize) -> (usize, f64, f64) {
    let [axis, place, below, _] =
        twin.paths.load((node % path_columns()) as i64, (node / path_columns()) as i64, 0);
    (usize::from(axis > 0.5), place, below)
}
