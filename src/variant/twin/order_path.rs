//! Random paths over orders in f64; see `templates/order_path.wgsl`.

use glam::{DVec2, DVec3, DVec4, Vec4Swizzles};

use crate::tables::paths::wavelength_cells;
use crate::variant::Orders;

use super::Twin;
use super::arrivals::{
    arrival, from_surface, in_surface, normal_reflectance, order_frequency, order_share,
};

/// A path from three random numbers: the direction to the light, and the wavelength in µm.
pub fn diffraction_path(twin: &Twin<'_>, form: &Orders, wr: DVec3, random: DVec3) -> DVec4 {
    let viewer = in_surface(twin, wr);
    let lambda_um = drawn_wavelength(twin, form, random.z);
    let frequency = order_frequency(form, drawn_order(twin, form, random.truncate()));
    from_surface(twin, arrival(frequency, lambda_um, viewer)).extend(lambda_um)
}

/// Light of a linear RGB colour at a wavelength in µm, relative to white light.
pub fn diffraction_light(twin: &Twin<'_>, form: &Orders, rgb: DVec3, lambda_um: f64) -> f64 {
    let place = wavelength_place(form, lambda_um);
    let cell = wavelength_cell(form, place);
    let [before, after] = [0, 1].map(|next| DVec4::from(twin.paths.load(cell + next, 2, 0)).yzw());
    rgb.dot(before.lerp(after, place - cell as f64))
}

/// X, Y, Z of a path's weight.
pub fn tristimulus_weight(twin: &Twin<'_>, form: &Orders, wr: DVec3, path: DVec4) -> DVec3 {
    if wr.z <= 1e-6 || path.z <= 1e-6 || path.w <= 0.0 {
        return DVec3::ZERO;
    }
    let viewer = in_surface(twin, wr);
    let shift = -in_surface(twin, path.truncate()).truncate() - viewer.truncate();
    let order = (shift / path.w * DVec2::from(form.sum.patch_um) + 0.5).floor();
    let reach = [form.axes.bins.r_max, form.axes.bins.s_max].map(|reach| reach as f64);
    if order.abs().cmpgt(DVec2::from(reach)).any() {
        return DVec3::ZERO;
    }
    let column = (order.y + reach[1]) * (2.0 * reach[0] + 1.0) + order.x + reach[0];
    let [_, _, chance, _] = twin.paths.load(column as i64, 0, 0);
    let place = wavelength_place(form, path.w);
    let cell = wavelength_cell(form, place);
    let [before, after] = [0, 1].map(|next| DVec4::from(twin.paths.load(cell + next, 1, 0)).yzw());
    let light = before.lerp(after, place - cell as f64) / twin.paths.load(cell, 2, 0)[0];
    let share = order_share(twin, form, order, path.w, viewer);
    normal_reflectance(form) * share / chance * light
}

fn drawn_order(twin: &Twin<'_>, form: &Orders, random: DVec2) -> DVec2 {
    let bins = form.axes.bins;
    let count = bins.len() as i64;
    let column = ((random.x * count as f64) as i64).min(count - 1);
    let [threshold, other, ..] = twin.paths.load(column, 0, 0);
    let chosen = if random.y < threshold { column } else { other as i64 };
    let width = 2 * bins.r_max as i64 + 1;
    let (x, y) = (chosen % width - bins.r_max as i64, chosen / width - bins.s_max as i64);
    DVec2::new(x as f64, y as f64)
}

fn drawn_wavelength(twin: &Twin<'_>, form: &Orders, random: f64) -> f64 {
    let cells = wavelength_cells(form.sum.range_nm) as i64;
    let (mut cell, mut end) = (0, cells);
    while end - cell > 1 {
        let middle = (cell + end) / 2;
        if twin.paths.load(middle, 1, 0)[0] <= random {
            cell = middle;
        } else {
            end = middle;
        }
    }
    let below = twin.paths.load(cell, 1, 0)[0];
    let chance = twin.paths.load(cell, 2, 0)[0];
    let part = ((random - below) / chance).clamp(0.0, 1.0);
    let [min_um, max_um] = form.wavelengths_um();
    min_um + (cell as f64 + part) / cells as f64 * (max_um - min_um)
}

fn wavelength_place(form: &Orders, lambda_um: f64) -> f64 {
    let [min_um, max_um] = form.wavelengths_um();
    let share = ((lambda_um - min_um) / (max_um - min_um)).clamp(0.0, 1.0);
    share * wavelength_cells(form.sum.range_nm) as f64
}

fn wavelength_cell(form: &Orders, place: f64) -> i64 {
    (place as i64).min(wavelength_cells(form.sum.range_nm) as i64 - 1)
}
