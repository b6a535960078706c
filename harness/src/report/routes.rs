//! Comparisons of routes with each other and with the twin.

use maud::{Markup, html};

use super::gap::nothing;
use super::merge::{Results, Unit, unique};
use super::number;
use super::table::{Cell, Head, Row, heads, table};
use crate::results::{Compare, Part};

/// The section.
pub(super) fn section(results: &Results<'_>) -> Markup {
    let of = |part: Part| results.compared().filter(move |c| c.part == part);
    let mut routes = unique(of(Part::Arithmetic).chain(of(Part::Across)).map(|c| c.route.as_str()));
    routes.extend(of(Part::Across).map(|c| c.reference.as_str()));
    let routes = unique(routes);
    if routes.is_empty() {
        return nothing("no driver was compared", "cargo xtask compare");
    }
    html! {
        p {
            "The same shader reaches drivers by several routes. The numbers are maximum differences of tristimulus values, relative to "
            "the reference's maximum, worst over surfaces, variants and lights. ✗ marks differences over their tolerance."
        }
        (matrix(results, &routes))
        h3 { "Each variant" }
        (variants(results, &routes))
    }
}

fn matrix(results: &Results<'_>, routes: &[&str]) -> Markup {
    let worst = |part: Part, route: &str, partner: Option<&str>| {
        let found = results.compared().filter(|c| {
            c.part == part
                && c.route == route
                && partner.is_none_or(|partner| c.reference == partner)
        });
        judged(found.collect())
    };
    let mut names = heads(["route", "twin"]);
    names.extend(routes.iter().map(|route| Head((*route).to_owned(), "")));
    names.push(Head("comparisons".into(), ""));
    let rows: Vec<Row> = routes
        .iter()
        .map(|route| {
            let mut row = vec![Cell::text(route), worst(Part::Arithmetic, route, None)];
            row.extend(routes.iter().map(|partner| worst(Part::Across, route, Some(partner))));
            let count = results.compared().filter(|c| c.route == *route).count();
            row.push(Cell::count(count));
            (None, row)
        })
        .collect();
    html! {
        (table("matrix", "Routes against the twin (64 bits) and against each other", &names, &rows))
        p.note { "For each map, a route is compared only with the route that differs most from it. A dash: this pair was never compared." }
    }
}

/// The maximum difference, marked as failed if any of them failed.
fn judged(found: Vec<&Compare>) -> Cell {
    let worst = found.iter().map(|c| c.max_abs).reduce(f64::max);
    worst.map_or_else(Cell::none, |worst| Cell::judged(worst, found.iter().all(|c| c.pass)))
}

fn variants(results: &Results<'_>, routes: &[&str]) -> Markup {
    let mut names = heads(["variant", "surface", "light", "allowed"]);
    names.extend(routes.iter().map(|route| Head(format!("{route} / twin"), "")));
    names.extend(heads(["routes apart", "which"]));
    let row = |unit: &Unit<'_>| -> Row {
        let allowed = unit.of(Part::Arithmetic).find_map(|c| c.tolerance.and_then(|t| t.max_abs));
        let mut row = vec![
            Cell::markup(html! { a href={ "#" (unit.anchor) } { (unit.variant) } }),
            Cell::text(unit.surface),
            Cell::text(number::lit(&unit.light)),
            Cell::maybe(allowed),
        ];
        row.extend(routes.iter().map(|route| {
            judged(unit.of(Part::Arithmetic).filter(|c| c.route == *route).collect())
        }));
        let across = unit.worst(Part::Across);
        row.push(across.map_or_else(Cell::none, |c| Cell::judged(c.max_abs, c.pass)));
        row.push(
            across
                .map_or_else(Cell::none, |c| Cell::text(format!("{} / {}", c.route, c.reference))),
        );
        (None, row)
    };
    let is_driven =
        |unit: &&Unit<'_>| unit.of(Part::Arithmetic).chain(unit.of(Part::Across)).next().is_some();
    let rows: Vec<Row> = results.units.iter().filter(is_driven).map(row).collect();
    table(
        "arithmetic",
        "Maximum difference of each variant from its twin, and between two routes",
        &names,
        &rows,
    )
}
