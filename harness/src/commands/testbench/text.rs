//! Results as a table for people.

use std::fmt::Write;

use crate::period::Protocol;
use crate::results::{Gap, Testbench};

/// The table: one line for each result.
pub(super) fn table(
    surface: &str,
    protocol: &Protocol,
    results: &[Testbench],
    gaps: &[Gap],
) -> String {
    let waves = protocol.wavelengths;
    let mut text = format!(
        "surface {surface}: θi {}°, φi {}°, {} to {} nm by {}, expected period {:.3} nm\n\n",
        protocol.theta_i_deg,
        protocol.phi_i_deg,
        waves.min_nm,
        waves.max_nm,
        waves.step_nm,
        1e3 * protocol.expected_um
    );
    let name = |variant: &str, route: &str| match variant == route {
        true => variant.to_owned(),
        false => format!("{variant} ({route})"),
    };
    let names = results.iter().map(|r| name(&r.variant, &r.route));
    let names: Vec<String> =
        names.chain(gaps.iter().map(|g| g.variant.clone().unwrap_or_default())).collect();
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0).max(7);
    let has_windows = results.iter().any(|r| r.window.is_some());
    let head = if has_windows { "window (column, row, pixels)" } else { "closed form nm       sd" };
    // writing to a string cannot fail
    let _ = writeln!(
        text,
        "{:width$}  {:>11} {:>9}  {:>6} {:>8}  {:>9}  {head}",
        "variant", "period nm", "sd nm", "points", "left out", "weight"
    );
    for (name, r) in names.iter().zip(results) {
        let tail = match (r.window, r.windows, r.closed_nm) {
            (Some([x, y, columns, rows]), _, _) => format!("{x}, {y}, {columns} × {rows}"),
            (_, Some((windows, spread_nm)), _) => {
                format!("mean of {windows} windows, which differ by {spread_nm:.3} nm (sd)")
            }
            (_, _, Some([mean_nm, sd_nm])) => format!("{mean_nm:>14.4} {sd_nm:>8.4}"),
            _ => "-".to_owned(),
        };
        let _ = writeln!(
            text,
            "{name:width$}  {:>11.4} {:>9.4}  {:>6} {:>8}  {:>9.3e}  {tail}",
            r.period_nm,
            r.sd_nm,
            r.points,
            r.evanescent + r.flat,
            r.weight
        );
    }
    for (gap, name) in gaps.iter().zip(&names[results.len()..]) {
        let _ = writeln!(text, "{name:width$}  {}", gap.reason);
    }
    text + "\nThe efficiency of an order varies over its lobe and shifts its peak away from the grating equation, also in the closed form.\n"
}
