//! Results as tables for people.

use std::collections::BTreeMap;

use crate::commands::digits::digits;
use crate::results::{LightError, Tune, Verdict};
use crate::tune::prune::mib;

use diffraction_cli::list::table;

/// Maximum number of names for each reason.
const NAMES: usize = 3;
/// Maximum number of reasons for each verdict.
const REASONS: usize = 3;

/// The measured candidates, the front, the winner with its preset, and why the others lost.
pub(super) fn text(records: &[Tune], all: bool) -> String {
    let Some(first) = records.first() else { return String::new() };
    let lights: Vec<String> = first.lights.iter().map(|[t, p]| format!("{t},{p}")).collect();
    let mut text = format!(
        "{}: p95 of CIEDE2000 at most {} under the lights {}; times on {} {} at {} × {} pixels\n\n",
        first.surface,
        first.budget_de,
        lights.join(" "),
        first.backend,
        first.adapter,
        first.size,
        first.size
    );
    text += &measured(records);
    text += &lost(records, all);
    if let Some(winner) = records.iter().find(|r| r.verdict == Verdict::Winner) {
        let ratio = winner.time.map_or(0.0, |time| time.ratio);
        let p95 = winner.worst_p95().unwrap_or(0.0);
        text += &format!(
            "\nwinner: {}, {} times as fast as texts at p95 {p95:.3}\n\n{}",
            winner.variant,
            digits(ratio),
            winner.preset
        );
    }
    text
}

/// For a search without a winner: the nearest candidate, and what would help.
pub(super) fn help(records: &[Tune]) -> String {
    let budget = records.first().map_or(0.0, |r| r.budget_de);
    let of = |verdict| {
        let error = |r: &&Tune| r.worst_p95().or(r.far_p95).unwrap_or(f64::INFINITY);
        let all = records.iter().filter(move |r| r.verdict == verdict);
        all.min_by(|a, b| error(a).total_cmp(&error(b)))
    };
    let mut text = format!("no candidate is within a p95 of {budget}");
    match of(Verdict::Over).or_else(|| of(Verdict::Far)) {
        Some(nearest) => {
            let p95 = nearest.worst_p95().or(nearest.far_p95).unwrap_or(0.0);
            let light = worst(nearest).map(|l| format!(" at light {},{}", l.light[0], l.light[1]));
            let light = light.unwrap_or_else(|| " at least".to_owned());
            let name = &nearest.variant;
            text += &format!(
                "; the nearest is {name} with {p95:.3}{light}: raise the budget to take it"
            );
        }
        None => text += "; no candidate was worth measuring, for the reasons above",
    }
    let count = |verdict| records.iter().filter(|r| r.verdict == verdict).count();
    for (verdict, flag) in [(Verdict::Unfit, "--fits"), (Verdict::Large, "--max-table-mib")] {
        if count(verdict) > 0 {
            text += &format!("; without {flag} there would be {} more candidates", count(verdict));
        }
    }
    text
}

fn worst(record: &Tune) -> Option<&LightError> {
    record.errors.iter().max_by(|a, b| a.worst_p95().total_cmp(&b.worst_p95()))
}

fn measured(records: &[Tune]) -> String {
    let mut rows: Vec<&Tune> = records.iter().filter(|r| !r.errors.is_empty()).collect();
    let time = |r: &Tune| r.time.map_or(f64::INFINITY, |time| time.ns_per_pixel);
    rows.sort_by(|a, b| time(a).total_cmp(&time(b)).then(a.verdict.cmp(&b.verdict)));
    let none = || "-".to_owned();
    let cells = rows.iter().map(|r| {
        let worst = worst(r);
        let verdict = match (r.front, r.verdict.words()) {
            (true, words) => format!("{words}, on the front"),
            (false, words) => words.to_owned(),
        };
        vec![
            r.variant.clone(),
            worst.map_or_else(none, |error| format!("{:.3}", error.worst_p95())),
            worst.map_or_else(none, |error| format!("{},{}", error.light[0], error.light[1])),
            r.worst_max().map_or_else(none, |max| format!("{max:.2}")),
            r.time.map_or_else(none, |time| digits(time.ns_per_pixel)),
            r.time.map_or_else(none, |time| digits(time.ratio)),
            r.time.map_or_else(none, |time| {
                let [low, high] = time.ratio_interval;
                format!("{} … {}", digits(low), digits(high))
            }),
            r.fetches.map_or_else(none, |fetches| format!("{fetches:.1}")),
            r.table_bytes.map_or_else(none, |bytes| format!("{:.3}", mib(bytes))),
            verdict,
        ]
    });
    let head = [
        "measured",
        "p95",
        "at light",
        "max",
        "ns/pixel",
        "ratio to texts",
        "95 %",
        "fetches",
        "MiB",
        "verdict",
    ];
    table::text(&head, cells.collect())
        + "p95: under the worst light, over all directions or the map alone, whichever is larger; fetches: mean per lit pixel\n\n"
        + &front(&rows)
}

/// The candidates on the front, from the fastest to the most exact. `rows` are in the order of their times.
fn front(rows: &[&Tune]) -> String {
    let on = rows.iter().filter(|r| r.front);
    let shown: Vec<String> = on
        .filter_map(|r| {
            let [ns, p95] = r.place()?;
            Some(format!("{} ({} ns, {p95:.3})", r.variant, digits(ns)))
        })
        .collect();
    match shown.is_empty() {
        true => String::new(),
        false => {
            format!("front (no other is both faster and more exact): {}\n\n", shown.join(", "))
        }
    }
}

/// The other candidates, by verdict, then by reason.
fn lost(records: &[Tune], all: bool) -> String {
    let mut groups: BTreeMap<Verdict, BTreeMap<&str, Vec<&str>>> = BTreeMap::new();
    for record in records.iter().filter(|r| r.errors.is_empty()) {
        let reasons = groups.entry(record.verdict).or_default();
        reasons.entry(&record.why).or_default().push(&record.variant);
    }
    let mut text = String::new();
    for (verdict, reasons) in groups {
        let count: usize = reasons.values().map(Vec::len).sum();
        text += &format!("{} ({count}):\n", verdict.words());
        let limit = if all { reasons.len() } else { REASONS };
        let rest: usize = reasons.values().skip(limit).map(Vec::len).sum();
        for (why, names) in reasons.into_iter().take(limit) {
            let limit = if all { names.len() } else { NAMES };
            let shown = names.iter().take(limit).copied().collect::<Vec<_>>().join(", ");
            let more = match names.len().saturating_sub(limit) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            text += &format!("  {why}: {shown}{more}\n");
        }
        if rest > 0 {
            text += &format!("  and {rest} more for similar reasons; --all lists them\n");
        }
    }
    text
}
