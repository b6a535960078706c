//! Sweeps: variants of a surface that differ in one setting only, side by side.

mod group;

use maud::{Markup, html};

use super::album::{Picture, map};
use super::gap::nothing;
use super::merge::{Results, Unit, unique};
use super::number::{self, figure};
use super::plot::{Plot, PlotAxis, Point, Scale, Series, draw};
use super::table::{self, Cell, Row, heads, table};

use group::{Group, Value, groups};

/// The section.
pub(super) fn section(results: &Results<'_>) -> Markup {
    let groups = groups(&results.units);
    if groups.is_empty() {
        return nothing(
            "no variants that differ in one setting only, and no second light",
            "cargo xtask compare",
        );
    }
    let surfaces = unique(groups.iter().map(|g| g.surface));
    html! {
        p { "Maps of variants that differ in one setting only, in the order of that setting. For each setting the longest sweep is open. Other sweeps, and those with two steps, are folded." }
        @for surface in surfaces {
            @let own: Vec<(usize, &Group<'_>)> =
                groups.iter().enumerate().filter(|(_, g)| g.surface == surface).collect();
            h3 { (surface) }
            @let (open, folded): (Vec<_>, Vec<_>) = own.iter().copied().partition(|(i, g)| is_open(*i, g, &own));
            @for (i, group) in open { (gallery(i, group)) }
            @if !folded.is_empty() {
                details {
                    summary { (folded.len()) " more on " (surface) }
                    @for (i, group) in folded { (gallery(i, group)) }
                }
            }
        }
    }
}

/// Whether a sweep is the longest of its setting, with more than two steps.
fn is_open(number: usize, group: &Group<'_>, own: &[(usize, &Group<'_>)]) -> bool {
    let alike = own.iter().filter(|(_, other)| other.key == group.key);
    let longest =
        alike.max_by(|a, b| a.1.members.len().cmp(&b.1.members.len()).then(b.0.cmp(&a.0)));
    group.members.len() > 2 && longest.is_some_and(|(first, _)| *first == number)
}

/// Name of a setting, with its unit.
fn called(key: &str) -> &str {
    match key {
        "step_nm" => "wavelength step, nm",
        "coherence_um" => "coherence length, µm",
        "terms" => "terms of the series",
        "mode" => "mode",
        "light" => "light",
        "window_radius" => "radius of the window, bins",
        "table" => "format of the tables",
        "basis" => "basis of the series",
        other => other,
    }
}

fn gallery(number: usize, group: &Group<'_>) -> Markup {
    let id = format!("sweep-{}", number + 1);
    let title = format!("{}: {}", group.surface, called(&group.key));
    let exact =
        |unit: &Unit<'_>| unit.total().and_then(|(_, strip)| strip.as_ref().map(|s| s[0].clone()));
    let references = unique(group.members.iter().map(|(_, unit)| exact(unit)));
    let shared = match references.as_slice() {
        [Some(one @ Picture::Drawn(_))] => Some(one.clone()),
        _ => None,
    };
    let caption = html! {
        b { (called(&group.key)) } ": each variant's map" @if shared.is_none() { ", its exact reference" }
        " and the difference × 10. Below them: ΔE₀₀ p95 against the exact reference."
    };
    html! {
        div.sweep id=(id) {
            h4 { (called(&group.key)) span.dim { " · otherwise like " (group.like) } }
            figure {
                div.gallery tabindex="0" role="region" aria-label=(title) {
                    @if let Some(exact) = &shared {
                        div.cell { (map(exact, "exact reference")) b { "exact" } }
                    }
                    @for (value, unit) in &group.members { (cell(value, unit, shared.is_none())) }
                }
                figcaption { (caption) " " a.data href={ "#" (id) "-data" } { "Data" } }
            }
            div.pair {
                (table::figure(&draw(&chart(&title, group)), &html! { "ΔE₀₀ p95 against " (called(&group.key)) "." }, &format!("{id}-data")))
                (numbers(&format!("{id}-data"), &title, group))
            }
        }
    }
}

fn cell(value: &Value, unit: &Unit<'_>, with_exact: bool) -> Markup {
    let alt = |what: &str| {
        format!("{what}: {} on {}, light {}", unit.variant, unit.surface, number::lit(&unit.light))
    };
    html! {
        div.cell {
            @if let Some((compare, strip)) = unit.total() {
                @if let Some(strip) = strip {
                    @if with_exact { (map(&strip[0], &alt("exact"))) }
                    (map(&strip[1], &alt("variant")))
                    (map(&strip[2], &alt("difference × 10")))
                }
                b { a href={ "#" (unit.anchor) } { (value.shown()) } }
                span.n { "ΔE₀₀ " (figure(compare.worst_p95())) }
            }
        }
    }
}

fn chart(title: &str, group: &Group<'_>) -> Plot {
    let numbers: Vec<Option<f64>> = group.members.iter().map(|(value, _)| value.number()).collect();
    let all: Option<Vec<f64>> = numbers.into_iter().collect();
    let scale = match &all {
        Some(values) => {
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            let greatest = values.iter().copied().fold(0.0, f64::max);
            if least > 0.0 && greatest / least >= 8.0 { Scale::Log } else { Scale::Linear }
        }
        None => {
            Scale::Names(group.members.iter().map(|(value, _)| short(&value.shown())).collect())
        }
    };
    let point = |(i, (value, unit)): (usize, &(Value, &Unit<'_>))| {
        let (compare, _) = unit.total()?;
        Some(Point {
            at: [all.as_ref().map_or(i as f64, |all| all[i]), compare.worst_p95()],
            spread: None,
            label: String::new(),
            note: format!(
                "{} {}: ΔE₀₀ p95 {}",
                called(&group.key),
                value.shown(),
                figure(compare.worst_p95())
            ),
            link: unit.anchor.clone(),
        })
    };
    Plot {
        title: format!("ΔE₀₀ p95 against {title}"),
        x: PlotAxis { label: called(&group.key).to_owned(), scale },
        y: PlotAxis { label: "ΔE₀₀ p95".into(), scale: Scale::Log },
        series: vec![Series {
            name: String::new(),
            joined: all.is_some(),
            points: group.members.iter().enumerate().filter_map(point).collect(),
        }],
        dashed: Vec::new(),
    }
}

/// A name short enough for a tick.
fn short(name: &str) -> String {
    match name.char_indices().nth(11) {
        Some((at, _)) => format!("{}…", &name[..at]),
        None => name.to_owned(),
    }
}

fn numbers(id: &str, title: &str, group: &Group<'_>) -> Markup {
    let rows: Vec<Row> = group
        .members
        .iter()
        .filter_map(|(value, unit)| {
            let (c, _) = unit.total()?;
            let first = match value.number() {
                Some(number) => Cell::shown(number, value.shown()),
                None => Cell::text(value.shown()),
            };
            let d = c.de2000;
            let numbers = [d.mean, d.p50, d.p95, d.p99, d.max].map(Cell::number);
            let map = Cell::maybe(c.map.map(|map| map.de2000.p95));
            let rest = [map, Cell::maybe(c.flip), Cell::number(c.max_abs), Cell::text(&c.route)];
            let name = Cell::markup(html! { a href={ "#" (unit.anchor) } { (unit.variant) } });
            Some((None, [first, name].into_iter().chain(numbers).chain(rest).collect()))
        })
        .collect();
    let names = [
        called(&group.key),
        "variant",
        "ΔE₀₀ mean",
        "p50",
        "p95",
        "p99",
        "max",
        "map p95",
        "FLIP",
        "max |Δ|",
        "route",
    ];
    table(id, title, &heads(names), &rows)
}
