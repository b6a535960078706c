//! The summary: what was measured, what passed, which controls were caught, what is missing, what is worst.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::gap::nothing;
use super::merge::{Results, unique};
use super::number::{self, figure};
use super::table::{Cell, Row, heads, table};
use crate::results::{Compare, Part};

/// Number of listed comparisons that are nearest to their tolerance.
const NEAREST: usize = 12;

/// The section.
pub(super) fn section(results: &Results<'_>) -> Markup {
    html! {
        (facts(results))
        h3 { "Verdicts" }
        (verdicts(results))
        h3 { "Negative controls" }
        (controls(results))
        h3 { "Nearest to their tolerance, or over it" }
        (worst(results))
        h3 { "Not measured" }
        (gaps(results))
        @if !results.missing.is_empty() {
            h3 { "Missing pictures" }
            ul.missing { @for missing in &results.missing { li { (missing) } } }
        }
    }
}

fn facts(results: &Results<'_>) -> Markup {
    let units = &results.units;
    let compared = || results.compared();
    let surfaces = unique(units.iter().map(|u| u.surface));
    let variants = unique(units.iter().map(|u| u.variant));
    let routes = unique(compared().map(|c| c.route.as_str()).filter(|r| *r != "twin:unpacked"));
    let lights = unique(units.iter().map(|u| number::lit(&u.light)));
    let sizes = unique(units.iter().map(|u| format!("{0} × {0}", u.size)));
    let adapters = unique(results.benches.iter().map(|b| format!("{}:{}", b.backend, b.adapter)));
    let count = compared().count();
    let failed = compared().filter(|c| !c.pass).count();
    let caught = results.controls.iter().filter(|c| c.caught).count();
    let controls = results.controls.len();
    html! {
        div.tiles {
            (tile(count, "comparisons", (failed == 0 && count > 0).then_some("all within tolerance"), (failed > 0).then(|| format!("{failed} over tolerance"))))
            (tile(controls, "negative controls", (caught == controls && controls > 0).then_some("all caught"), (caught < controls).then(|| format!("{} missed", controls - caught))))
            (tile(results.benches.len(), "times", None, None))
            (tile(results.periods.len(), "periods", None, None))
        }
        dl.facts {
            (fact("Results of", &results.folders))
            (fact("Surfaces", &surfaces))
            (fact("Variants", &variants))
            (fact("Routes", &routes))
            (fact("Adapters timed", &adapters))
            (fact("Lights", &lights))
            (fact("Maps, pixels", &sizes))
            @if results.replaced > 0 {
                (fact("Replaced", &[format!("{} results by later ones of the same measurement", results.replaced)]))
            }
        }
    }
}

fn tile(count: usize, what: &str, good: Option<&str>, bad: Option<String>) -> Markup {
    html! {
        div.tile {
            b { (count) } span { (what) }
            @if let Some(good) = good { em.good { "✓ " (good) } }
            @if let Some(bad) = bad { em.bad { "✗ " (bad) } }
        }
    }
}

fn fact(name: &str, values: &[impl AsRef<str>]) -> Markup {
    html! {
        @if !values.is_empty() {
            div {
                dt { (name) }
                dd { @for value in values { span { (value.as_ref()) } " " } }
            }
        }
    }
}

/// The parts of the error, each with its name and meaning.
pub(super) const PARTS: [(Part, &str, &str); 5] = [
    (Part::Total, "total", "the colours by a route against the exact reference"),
    (
        Part::Model,
        "model",
        "the variant's approximation: 64 bits, unrounded tables, against the exact reference",
    ),
    (
        Part::Packing,
        "packing",
        "the rounding of the tables: 64 bits, rounded against unrounded tables",
    ),
    (Part::Arithmetic, "arithmetic", "a driver's 32 bits against 64 bits on the same tables"),
    (Part::Across, "across", "a route against the route that differs most from it"),
];

fn verdicts(results: &Results<'_>) -> Markup {
    if results.units.is_empty() {
        return nothing("no comparisons", "cargo xtask compare");
    }
    let rows: Vec<Row> = PARTS
        .iter()
        .filter_map(|(part, name, meaning)| {
            let all: Vec<&Compare> = results.compared().filter(|c| c.part == *part).collect();
            let failed = all.iter().filter(|c| !c.pass).count();
            let judged = all.iter().filter(|c| c.tolerance.is_some()).count();
            let worst = |f: fn(&Compare) -> f64| all.iter().map(|c| f(c)).reduce(f64::max);
            (!all.is_empty()).then(|| {
                let row = vec![
                    Cell::text(name),
                    Cell::prose(meaning),
                    Cell::count(all.len()),
                    Cell::count(judged),
                    Cell::failures(failed),
                    Cell::maybe(worst(Compare::worst_p95)),
                    Cell::maybe(worst(|c| c.max_abs)),
                ];
                (None, row)
            })
        })
        .collect();
    let names = [
        "error",
        "meaning",
        "comparisons",
        "judged",
        "over tolerance",
        "worst ΔE₀₀ p95",
        "worst max |Δ|",
    ];
    table("verdicts", "Comparisons by part of the error", &heads(names), &rows)
}

fn controls(results: &Results<'_>) -> Markup {
    if results.controls.is_empty() {
        return nothing("no negative controls", "cargo xtask compare");
    }
    let routes = unique(results.controls.iter().map(|c| c.route.as_str()));
    let kinds = unique(
        results
            .controls
            .iter()
            .map(|c| (c.control.as_str(), c.surface.as_str(), c.variant.as_str())),
    );
    let mut names = heads(["made wrong", "surface", "variant"]);
    names.extend(routes.iter().map(|route| super::table::Head((*route).to_owned(), "")));
    let rows: Vec<Row> = kinds
        .iter()
        .map(|(control, surface, variant)| {
            let mut row = vec![Cell::text(control), Cell::text(surface), Cell::text(variant)];
            row.extend(routes.iter().map(|route| {
                let of = results.controls.iter().find(|c| {
                    (&*c.control, &*c.surface, &*c.variant, &*c.route)
                        == (*control, *surface, *variant, *route)
                });
                of.map_or_else(Cell::none, |c| {
                    let shown = format!("caught, {}", figure(c.max_abs));
                    Cell::verdict(c.caught, &shown, "missed")
                })
            }));
            (None, row)
        })
        .collect();
    html! {
        p { "Shaders made wrong on purpose. Each must fail the comparison that the right shader passes. The number is the maximum "
        "difference from the right colours, relative to the maximum colour." }
        (table("controls", "Negative controls by route", &names, &rows))
        p.note { "A dash: this route did not run this control." }
    }
}

/// The share of its tolerance that a comparison uses; 1 is all of it.
fn used(c: &Compare) -> Option<f64> {
    let tolerance = c.tolerance?;
    let share = |value: f64, limit: Option<f64>| limit.map(|limit| value / limit);
    let shares = [
        share(c.max_abs, tolerance.max_abs),
        share(c.de2000.p95, tolerance.de2000_p95),
        share(c.map.map_or(0.0, |map| map.de2000.p95), tolerance.map_p95),
    ];
    shares.into_iter().flatten().reduce(f64::max)
}

fn worst(results: &Results<'_>) -> Markup {
    // one line for each surface, variant, light and part: the worst of its routes
    let mut worst: BTreeMap<String, (f64, &Compare, &str)> = BTreeMap::new();
    for unit in &results.units {
        for (c, _) in &unit.compared {
            let Some(used) = used(c) else { continue };
            let entry = worst.entry(format!("{} {:?}", unit.anchor, c.part)).or_insert((
                used,
                *c,
                &unit.anchor,
            ));
            if used > entry.0 {
                *entry = (used, *c, &unit.anchor);
            }
        }
    }
    let mut sorted: Vec<_> = worst.into_values().collect();
    sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
    let beyond = sorted.iter().filter(|(_, c, _)| !c.pass).count();
    sorted.truncate(NEAREST.max(beyond));
    if sorted.is_empty() {
        return nothing("no comparison with a tolerance", "cargo xtask compare");
    }
    let rows: Vec<Row> = sorted
        .into_iter()
        .map(|(used, c, anchor)| {
            let part =
                PARTS.iter().find(|(part, ..)| *part == c.part).map_or("", |(_, name, _)| name);
            let row = vec![
                Cell::markup(html! { a href={ "#" (anchor) } { (c.variant) } }),
                Cell::text(&c.surface),
                Cell::text(part),
                Cell::text(&c.route),
                Cell::text(&c.reference),
                Cell::number(c.worst_p95()),
                Cell::number(c.max_abs),
                Cell::judged(100.0 * used, c.pass),
            ];
            (None, row)
        })
        .collect();
    let names = [
        "variant",
        "surface",
        "error",
        "route",
        "against",
        "ΔE₀₀ p95",
        "max |Δ|",
        "% of the tolerance",
    ];
    table("worst", "Used share of the tolerance, worst route of each", &heads(names), &rows)
}

fn gaps(results: &Results<'_>) -> Markup {
    if results.gaps.is_empty() {
        return html! { p.nothing { "Everything was measured." } };
    }
    // one reason may hold for many routes, surfaces and variants: it is printed once
    let mut alike: BTreeMap<(bool, &str), [Vec<&str>; 3]> = BTreeMap::new();
    for gap in &results.gaps {
        let concerned = alike.entry((!gap.failed, &gap.reason)).or_default();
        let names = [Some(&gap.route), gap.surface.as_ref(), gap.variant.as_ref()];
        for (all, name) in concerned.iter_mut().zip(names) {
            all.extend(name.map(String::as_str).filter(|name| !all.contains(name)));
        }
    }
    let rows: Vec<Row> = alike
        .into_iter()
        .map(|((taken, reason), concerned)| {
            let [routes, surfaces, variants] = concerned.map(|all| Cell::prose(all.join(", ")));
            let kind = match taken {
                false => Cell::verdict(false, "", "failed"),
                true => Cell::text("not measured"),
            };
            (None, vec![kind, Cell::prose(reason), routes, surfaces, variants])
        })
        .collect();
    table(
        "gaps",
        "Routes, variants and adapters that were not measured, or not to the end",
        &heads(["kind", "reason", "routes", "surfaces", "variants"]),
        &rows,
    )
}
