//! The wavelength integral over nodes that depend on the direction, in f64; see `templates/warped.wgsl`.

use glam::DVec2;

use crate::field::reference::Directions;
use crate::variant::{Warped, node_level};

use super::Twin;
use super::matter::reflectance;
use super::prefiltered::response;

/// Relative tristimulus values for one pair of directions.
pub fn tristimulus(twin: &Twin<'_>, form: &Warped, Directions { wi, wr }: Directions) -> [f64; 3] {
    let coat = &form.coat;
    let factor = coat.matter.geometry(wi, wr);
    if factor == 0.0 {
        return [0.0; 3];
    }
    let path = coat.matter.path(wi, wr, twin.rotate_deg);
    let facing = coat.matter.facing_of(wi, wr);
    let row = node_row(twin, path.truncate());
    let mut xyz = [0.0; 3];
    for node in 0..twin.spectrum.width as i64 {
        let [x, y, z, lambda_um] = twin.spectrum.load(node, row, 0);
        if lambda_um == 0.0 {
            break;
        }
        let response = response(twin, &form.series, coat, path, lambda_um)
            * reflectance(twin, coat, lambda_um, facing);
        xyz = std::array::from_fn(|c| xyz[c] + [x, y, z][c] * response);
    }
    xyz.map(|c| c * factor)
}

/// Row of the nodes for (u, v).
fn node_row(twin: &Twin<'_>, uv: DVec2) -> i64 {
    let level = i64::from(node_level(uv.length()));
    if level == 0 || twin.spectrum.width == 1 { 0 } else { level + 1 }
}
