//! Orders under surroundings in f64; see `templates/environment.wgsl`.

use glam::{DMat3, DVec2, DVec3, DVec4};

use crate::light::Surroundings;
use crate::variant::Orders;

use super::Twin;
use super::arrivals::{
    arrival, from_surface, in_surface, normal_reflectance, order_frequency, order_share,
    propagating,
};

/// Tristimulus values of the radiance under surroundings.
pub fn tristimulus_environment(
    twin: &Twin<'_>,
    form: &Orders,
    around: &dyn Surroundings,
    wr: DVec3,
) -> [f64; 3] {
    if wr.z <= 1e-6 {
        return [0.0; 3];
    }
    let viewer = in_surface(twin, wr);
    let mut xyz = mirror_image(twin, form, around, viewer);
    let [x, y] = [form.axes.bins.r_max, form.axes.bins.s_max].map(|reach| reach as i64);
    for row in -y..=y {
        for column in -x..=x {
            if row != 0 || column != 0 {
                let order = DVec2::new(column as f64, row as f64);
                xyz += streak(twin, form, order, around, viewer);
            }
        }
    }
    (normal_reflectance(form) * xyz).to_array()
}

fn mirror_image(twin: &Twin<'_>, form: &Orders, around: &dyn Surroundings, wr: DVec3) -> DVec3 {
    let mut light = DMat3::ZERO;
    for cell in 0..i64::from(form.nodes) {
        let of = [0, 1, 2].map(|row| streak_light(twin, cell, row));
        let share = order_share(twin, form, DVec2::ZERO, of[0].w, wr);
        let [red, green, blue] = of.map(DVec4::truncate);
        light += share * DMat3::from_cols(red, green, blue);
    }
    let wi = DVec3::new(-wr.x, -wr.y, wr.z);
    light * around.seen(from_surface(twin, wi), 0.0)
}

fn streak(
    twin: &Twin<'_>,
    form: &Orders,
    order: DVec2,
    around: &dyn Surroundings,
    wr: DVec3,
) -> DVec3 {
    let mut xyz = DVec3::ZERO;
    let frequency = order_frequency(form, order);
    let range = propagating(form, frequency, wr);
    let (first, count) = form.streak_cells(frequency);
    let mut first_um = streak_light(twin, first, 1).w;
    for cell in first..first + count {
        let last_um = streak_light(twin, cell + 1, 1).w;
        let (low, high) = (first_um.max(range[0]), last_um.min(range[1]));
        if low < high {
            let part = (high - low) / (last_um - first_um);
            let of = [0, 1, 2].map(|row| streak_light(twin, cell, row));
            let rest = high - low;
            let lambda_um = match part < 0.999 {
                true => of[0].w.clamp(low + 0.3 * rest, low + 0.7 * rest),
                false => of[0].w,
            };
            let share = part * order_share(twin, form, order, lambda_um, wr);
            if share > 1e-6 {
                let wi = arrival(frequency, lambda_um, wr);
                let spread_rad = part * of[2].w * frequency.length() / wi.z.max(1e-4).sqrt();
                let radiance = around.seen(from_surface(twin, wi), spread_rad);
                let [red, green, blue] = of.map(DVec4::truncate);
                xyz += share * DMat3::from_cols(red, green, blue) * radiance;
            }
        }
        first_um = last_um;
    }
    xyz
}

fn streak_light(twin: &Twin<'_>, cell: i64, row: i64) -> DVec4 {
    DVec4::from(twin.streaks.load(cell, row, 0))
}
