//! The wavelength integral over fixed nodes in f64; see `templates/nodes.wgsl`.

use crate::field::reference::Directions;
use crate::optics::{gain, path_difference};

use super::Twin;

/// Relative tristimulus values for one pair of directions.
pub fn tristimulus(twin: &Twin<'_>, Directions { wi, wr }: Directions) -> [f64; 3] {
    let factor = gain(wi, wr, twin.optics);
    if factor == 0.0 {
        return [0.0; 3];
    }
    let path = path_difference(wi, wr, twin.rotate_deg);
    let mut xyz = [0.0; 3];
    for node in 0..twin.spectrum.width as i64 {
        let [x, y, z, lambda_um] = twin.spectrum.load(node, 0, 0);
        let response = twin.response(path, lambda_um).unwrap_or(0.0);
        xyz = std::array::from_fn(|c| xyz[c] + [x, y, z][c] * response);
    }
    xyz.map(|c| c * factor)
}
