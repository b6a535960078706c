//! Searches for the cheapest variant: the front, the winner with its preset, and why other candidates lost.

mod picture;

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::gap::nothing;
use super::merge::{Results, unique};
use super::number::{self, figure};
use super::plot::{Plot, PlotAxis, Point, Scale, Series, draw, front};
use super::table::{self, Cell, Row, heads, table};
use crate::results::{Tune, Verdict};

pub use picture::front_picture;

/// The section.
pub(super) fn section(results: &Results<'_>) -> Markup {
    if results.tunes.is_empty() {
        return nothing("no search for the cheapest variant", "cargo xtask tune");
    }
    let runs = unique(results.tunes.iter().map(|(folder, tune)| run(folder, tune)));
    html! {
        p { "Each search finds the cheapest variant whose 95th percentile of CIEDE2000 against the exact colours is within a budget: "
        "under every light, over all directions and over the map alone. Errors are computed in 64 bits on rounded tables." }
        @for (i, at) in runs.iter().enumerate() {
            @let tunes: Vec<&Tune> =
                results.tunes.iter().filter(|(folder, t)| run(folder, t) == *at).map(|(_, t)| *t).collect();
            (one(i + 1, &tunes))
        }
    }
}

type Asked<'a> = (&'a str, &'a str, f64, &'a str, &'a str, Option<&'a str>, Option<f64>);

/// The parameters of a search. Searches in different folders are different searches.
fn run<'a>(folder: &'a str, t: &'a Tune) -> Asked<'a> {
    (folder, &t.surface, t.budget_de, &t.backend, &t.adapter, t.fits.as_deref(), t.max_table_mib)
}

/// A candidate with a measured error, and its number in plot and table.
struct Numbered<'a> {
    number: usize,
    anchor: String,
    tune: &'a Tune,
}

fn one(number: usize, tunes: &[&Tune]) -> Markup {
    let Some(first) = tunes.first() else { return html! {} };
    let title = format!("{} on {}:{}", first.surface, first.backend, first.adapter);
    let measured: Vec<Numbered<'_>> = tunes
        .iter()
        .filter(|t| !t.errors.is_empty())
        .enumerate()
        .map(|(i, tune)| Numbered {
            number: i + 1,
            anchor: format!("tune-{number}-{}", i + 1),
            tune,
        })
        .collect();
    let lights = unique(first.lights.iter().map(|l| number::light(*l)));
    let winner = tunes.iter().find(|t| t.verdict == Verdict::Winner);
    let data = format!("tuned-{number}");
    let caption = html! {
        b { (title) } ", lights " (lights.join("; ")) ", " (first.size) " × " (first.size) " pixels: ΔE₀₀ p95 under the worst light, and the "
        "time of a pixel. The star is the winner. The line joins the front: candidates for which no other is both faster and more exact. "
        "The numbers are those in the first column of the table."
    };
    let asked = [
        first.fits.as_ref().map(|profile| format!("tables that {profile} guarantees")),
        first.max_table_mib.map(|mib| format!("at most {} MiB of tables", number::plain(mib))),
    ];
    html! {
        div.study {
            h3 { (title) ", ΔE₀₀ p95 at most " (number::plain(first.budget_de)) }
            @for text in asked.iter().flatten() { p.sub { "Required: " (text) "." } }
            div.pair {
                @if measured.iter().any(|m| m.tune.place().is_some()) {
                    (table::figure(&draw(&chart(&title, &measured)), &caption, &data))
                }
                @match winner {
                    Some(winner) => { (won(winner)) },
                    None => p.nothing { "No candidate is within the budget." },
                }
            }
            (numbers(&data, &title, &measured))
            (lost(&format!("{data}-lost"), tunes))
        }
    }
}

fn won(winner: &Tune) -> Markup {
    html! {
        div {
            h4 { "Winner: " (winner.variant) }
            p {
                @if let Some(time) = winner.time {
                    (figure(time.ratio)) "× as fast as texts (" (figure(time.ratio_interval[0])) "–" (figure(time.ratio_interval[1])) ")"
                }
                @if let Some(p95) = winner.worst_p95() { ", ΔE₀₀ p95 " (figure(p95)) }
            }
            p.sub { "To paste into a plan:" }
            pre { code { (winner.preset) } }
        }
    }
}

fn chart(title: &str, measured: &[Numbered<'_>]) -> Plot {
    let placed: Vec<(&Numbered<'_>, [f64; 2])> =
        measured.iter().filter_map(|m| Some((m, m.tune.place()?))).collect();
    let point = |m: &Numbered<'_>, at: [f64; 2]| Point {
        at,
        spread: None,
        label: if m.tune.verdict == Verdict::Winner { "★".into() } else { m.number.to_string() },
        note: format!("{}: {} ns, ΔE₀₀ p95 {}", m.tune.variant, figure(at[0]), figure(at[1])),
        link: m.anchor.clone(),
    };
    let series = unique(placed.iter().map(|(m, _)| mode(m.tune))).into_iter().map(|name| Series {
        joined: false,
        points: placed
            .iter()
            .filter(|(m, _)| mode(m.tune) == name)
            .map(|(m, at)| point(m, *at))
            .collect(),
        name,
    });
    Plot {
        title: format!("Error against time of candidates: {title}"),
        x: PlotAxis { label: "time of a pixel, ns".into(), scale: Scale::Log },
        y: PlotAxis { label: "ΔE₀₀ p95, worst light".into(), scale: Scale::Log },
        series: series.collect(),
        dashed: front(&placed.iter().map(|(_, at)| *at).collect::<Vec<_>>()),
    }
}

/// The meaning of a mark: the mode, and its reconstruction, unless that is a sum over bins.
fn mode(tune: &Tune) -> String {
    if tune.verdict == Verdict::Baseline {
        return tune.variant.clone();
    }
    let word = |key: &str| tune.settings.get(key).and_then(|word| word.as_str());
    match (word("mode"), word("reconstruction")) {
        (Some(mode), Some("prefiltered")) => format!("{mode}, prefiltered"),
        (mode, _) => mode.unwrap_or("other").to_owned(),
    }
}

fn numbers(id: &str, title: &str, measured: &[Numbered<'_>]) -> Markup {
    let row = |Numbered { number, anchor, tune }: &Numbered<'_>| {
        let time = tune.time;
        let ratio = time.map_or_else(Cell::none, |time| {
            let [low, high] = time.ratio_interval.map(figure);
            Cell::shown(time.ratio, format!("{}× ({low}–{high})", figure(time.ratio)))
        });
        let within = tune.worst_p95().is_none_or(|p95| p95 <= tune.budget_de);
        let is_judged = tune.verdict != Verdict::Baseline;
        let error = tune.worst_p95().map_or_else(Cell::none, |p95| match is_judged {
            true => Cell::judged(p95, within),
            false => Cell::number(p95),
        });
        let front = if tune.front { ", on the front" } else { "" };
        let row = vec![
            Cell::count(*number),
            Cell::text(&tune.variant),
            Cell::text(tune.verdict.words().to_owned() + front),
            error,
            Cell::maybe(tune.worst_max()),
            Cell::maybe(time.map(|time| time.ns_per_pixel)),
            ratio,
            Cell::maybe(tune.fetches),
            tune.table_bytes.map_or_else(Cell::none, |b| Cell::shown(b as f64, number::bytes(b))),
        ];
        (Some(anchor.clone()), row)
    };
    let names = [
        "no.",
        "candidate",
        "verdict",
        "ΔE₀₀ p95",
        "max",
        "ns per pixel",
        "ratio to texts (95 %)",
        "fetches",
        "tables",
    ];
    let rows: Vec<Row> = measured.iter().map(row).collect();
    table(id, &format!("Measured candidates: {title}"), &heads(names), &rows)
}

/// The other candidates, by verdict and reason.
fn lost(id: &str, tunes: &[&Tune]) -> Markup {
    let mut groups: BTreeMap<(Verdict, &str), Vec<&str>> = BTreeMap::new();
    for tune in tunes.iter().filter(|t| t.errors.is_empty()) {
        groups.entry((tune.verdict, &tune.why)).or_default().push(&tune.variant);
    }
    let rows: Vec<Row> = groups
        .into_iter()
        .map(|((verdict, why), names)| {
            let row = vec![
                Cell::text(verdict.words()),
                Cell::prose(why),
                Cell::count(names.len()),
                Cell::prose(names.join(", ")),
            ];
            (None, row)
        })
        .collect();
    html! {
        @if !rows.is_empty() {
            details {
                summary { "Why the other candidates lost" }
                (table(id, "Candidates that were not measured to the end", &heads(["verdict", "reason", "count", "candidates"]), &rows))
            }
        }
    }
}
