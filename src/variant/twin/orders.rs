//! The sum over orders under light from one direction in f64; see `templates/adaptive.wgsl` and
//! `templates/efficiencies.wgsl`.

use glam::{DVec2, DVec3};

use crate::field::reference::Directions;
use crate::optics::{gain, path_difference};
use crate::variant::Orders;

use super::efficiencies::efficiency;
use super::{Twin, adaptive};

/// Relative tristimulus values for one pair of directions.
pub fn tristimulus(twin: &Twin<'_>, form: &Orders, Directions { wi, wr }: Directions) -> [f64; 3] {
    let factor = gain(wi, wr, twin.optics);
    if factor == 0.0 {
        return [0.0; 3];
    }
    let path = path_difference(wi, wr, twin.rotate_deg);
    (corridor(twin, form, path) * factor).to_array()
}

/// The sum over lobes whose bins have efficiencies in a table.
pub fn corridor(twin: &Twin<'_>, form: &Orders, path: DVec3) -> DVec3 {
    let squared = |order: DVec2, lambda_um: f64| efficiency(twin, form, order, path.z / lambda_um);
    adaptive::corridor(twin, &form.sum, path, &squared)
}
