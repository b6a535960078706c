//! A table of what surfaces return of all light.

use maud::{Markup, html};

use super::gap::nothing;
use super::merge::Results;
use super::number::figure;
use super::table::{Cell, Row, heads, table};
use crate::results::Energy;

/// The section.
pub(super) fn section(results: &Results<'_>) -> Markup {
    if results.energies.is_empty() {
        return nothing("no radiance under a white sky", "cargo xtask compare --lights FILE.toml");
    }
    let rows: Vec<Row> = results.energies.iter().map(|energy| row(energy)).collect();
    let names = heads(["surface", "optics", "Y at 0°", "30°", "60°", "75°", "X, Y, Z at 0°"]);
    html! {
        p { "Radiance under a sky of radiance 1, by the exact sum over orders: what a surface returns of all light. The theory is scalar, so it may "
        "exceed the reflectance of the material, at grazing angles most of all. Directions are towards the viewer, from the normal." }
        (table("white-sky", "Radiance under a white sky", &names, &rows))
    }
}

fn row(energy: &Energy) -> Row {
    let optics = energy.optics.as_object().into_iter().flatten();
    let optics: Vec<String> = optics
        .map(|(key, value)| match value.as_str() {
            Some(word) => format!("{key} {word}"),
            None => format!("{key} {value}"),
        })
        .collect();
    let mut cells = vec![Cell::text(&energy.surface), Cell::prose(optics.join(", "))];
    cells.extend(energy.white_sky.map(|xyz| Cell::number(xyz[1])));
    cells.push(Cell::text(energy.white_sky[0].map(figure).join(", ")));
    (None, cells)
}
