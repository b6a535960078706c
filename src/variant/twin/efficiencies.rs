//! Efficiencies of orders in f64; see `templates/efficiencies.wgsl`.

use glam::DVec2;

use crate::variant::Orders;

use super::Twin;

/// Efficiency of an order at `w/λ` in 1/µm.
pub fn efficiency(twin: &Twin<'_>, form: &Orders, order: DVec2, turns: f64) -> f64 {
    let (r_max, s_max) = (form.axes.bins.r_max as i64, form.axes.bins.s_max as i64);
    let (r, s) = (order.x as i64, order.y as i64);
    if r.abs() > r_max || s.abs() > s_max {
        return 0.0;
    }
    let columns = form.axes.columns;
    let place = (-0.5 * form.axes.phase_min_um() * turns).clamp(0.0, 1.0) * f64::from(columns);
    let column = (place as i64).min(i64::from(columns) - 1);
    let row = (s + s_max) * (2 * r_max + 1) + r + r_max;
    let [value, slope, next, next_slope] = twin.terms.load(column, row, 0);
    let part = place - column as f64;
    let rise = next - value;
    let bend = 3.0 * rise - 2.0 * slope - next_slope;
    value + part * (slope + part * (bend + part * (slope + next_slope - 2.0 * rise)))
}
