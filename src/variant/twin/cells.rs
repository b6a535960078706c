//! Cells of `(u, v)` under surroundings in f64; see `templates/cells.wgsl`.

use glam::{DMat3, DVec2, DVec3, DVec4};

use crate::light::Surroundings;
use crate::variant::Baked;

use super::Twin;
use super::baked::layer_share;

/// Tristimulus values of the radiance under surroundings.
pub fn tristimulus_environment(
    twin: &Twin<'_>,
    form: &Baked,
    around: &dyn Surroundings,
    wr: DVec3,
) -> [f64; 3] {
    let Some(cells) = form.cells.as_ref().filter(|_| wr.z > 1e-6) else { return [0.0; 3] };
    let matter = &form.coat.matter;
    let turn = DVec2::from_angle(twin.rotate_deg.to_radians());
    let last = f64::from(cells.axes.levels - 1);
    let mut xyz = DVec3::ZERO;
    for cell in 0..i64::from(cells.count) {
        let place = DVec4::from(twin.streaks.load(cell, 0, 0));
        let plane = -wr.truncate() - turn.rotate(place.truncate().truncate());
        let squared = plane.length_squared();
        if squared < 0.9999 {
            let wi = plane.extend((1.0 - squared).sqrt());
            let light = around.seen(wi, place.z / wi.z.sqrt());
            let path = matter.path(wi, wr, twin.rotate_deg);
            let squared = path.truncate().length_squared();
            let layer = layer_share(&cells.axes, path.z, squared) * last;
            let below = layer.floor().min(last - 1.0);
            let [one, next] =
                [0, 3].map(|more| cell_light(twin, cell, 1 + 3 * below as i64 + more, light));
            xyz += matter.geometry(wi, wr) / wi.z * one.lerp(next, layer - below);
        }
    }
    xyz.to_array()
}

/// X, Y, Z of a cell under light of a colour.
fn cell_light(twin: &Twin<'_>, cell: i64, first: i64, light: DVec3) -> DVec3 {
    let of = |row: i64| DVec4::from(twin.streaks.load(cell, first + row, 0)).truncate();
    DMat3::from_cols(of(0), of(1), of(2)) * light
}
