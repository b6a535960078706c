//! The wavelength integral over fixed nodes in f64; see `templates/nodes.wgsl`.

use crate::field::reference::Directions;
use crate::variant::Coat;

use super::Twin;
use super::matter::reflectance;

/// Relative tristimulus values for one pair of directions.
pub fn tristimulus(twin: &Twin<'_>, coat: &Coat, Directions { wi, wr }: Directions) -> [f64; 3] {
    let factor = coat.matter.geometry(wi, wr);
    if factor == 0.0 {
        return [0.0; 3];
    }
    let path = coat.matter.path(wi, wr, twin.rotate_deg);
    let facing = coat.matter.facing_of(wi, wr);
    let mut xyz = [0.0; 3];
    for node in 0..twin.spectrum.width as i64 {
        let [x, y, z, lambda_um] = twin.spectrum.load(node, 0, 0);
        let response = twin.response(path, lambda_um).unwrap_or(0.0)
            * reflectance(twin, coat, lambda_um, facing);
        xyz = std::array::from_fn(|c| xyz[c] + [x, y, z][c] * response);
    }
    xyz.map(|c| c * factor)
}
