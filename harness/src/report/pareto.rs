//! Plots of error against time, for each adapter and surface.

use maud::{Markup, html};

use super::gap::nothing;
use super::merge::{Results, unique};
use super::number::{self, figure};
use super::plot::{Plot, PlotAxis, Point, Scale, Series, draw, front};
use super::table::{self, Cell, Row, heads, table};
use crate::results::{Bench, Lit, Part};

/// The section.
pub(super) fn section(results: &Results<'_>) -> Markup {
    if results.benches.is_empty() {
        return nothing("no times", "cargo xtask bench");
    }
    let places = unique(results.benches.iter().map(|b| place(b)));
    html! {
        p { "Lower is more exact, further left is faster. The line joins the front: variants for which no other is both faster and more exact." }
        div.plots {
            @for (i, at) in places.iter().enumerate() {
                @let benches: Vec<&Bench> = results.benches.iter().filter(|b| place(b) == *at).copied().collect();
                (one(results, i + 1, &benches))
            }
        }
    }
}

/// What two times must share to be compared: backend, adapter, surface, light, size.
fn place(b: &Bench) -> (&str, &str, &str, [f64; 2], [usize; 2]) {
    (&b.backend, &b.adapter, &b.surface, b.light, [b.size, b.height.unwrap_or(b.size)])
}

/// A variant with its time and error.
struct Timed<'a> {
    bench: &'a Bench,
    /// 95th percentile of CIEDE2000, and its anchor in the page.
    error: Option<(f64, String)>,
    anchor: String,
    /// Its number in plot and table.
    number: usize,
}

fn one(results: &Results<'_>, number: usize, benches: &[&Bench]) -> Markup {
    let Some(first) = benches.first() else { return html! {} };
    let timed: Vec<Timed<'_>> = benches
        .iter()
        .enumerate()
        .map(|(i, bench)| Timed {
            bench,
            error: error(results, bench),
            anchor: format!("time-{number}-{}", i + 1),
            number: i + 1,
        })
        .collect();
    let without = timed.iter().filter(|t| t.error.is_none()).count();
    let title = format!("{} on {}:{}", first.surface, first.backend, first.adapter);
    let data = format!("times-{number}");
    let caption = html! {
        b { (title) } ", light " (number::light(first.light)) ", " (first.size) " × " (first.height.unwrap_or(first.size))
        " pixels: ΔE₀₀ p95 against the exact reference, and the median time of a frame with its 95 % interval. The numbers are those in the first column of the table."
        @if without > 0 { " " (without) " variants without a comparison here are in the table only." }
    };
    html! {
        div.study {
            h3 { (title) }
            @if without < timed.len() {
                div.pair {
                    (table::figure(&draw(&chart(&title, &timed)), &caption, &data))
                    (best(&timed))
                }
            } @else {
                p.nothing { "No variant has both a time and a comparison on this surface." }
            }
            (numbers(&data, &title, &timed))
        }
    }
}

/// The error of a timed variant: under the same light if it was compared there, else under the worst light.
fn error(results: &Results<'_>, bench: &Bench) -> Option<(f64, String)> {
    let of = || {
        results
            .units
            .iter()
            .filter(|u| (u.surface, u.variant) == (&*bench.surface, &*bench.variant))
    };
    let same = of().filter(|u| u.light == Lit::Direction(bench.light));
    let worst = |units: &mut dyn Iterator<Item = &super::merge::Unit<'_>>| {
        units
            .filter_map(|u| u.worst(Part::Total).map(|c| (c.worst_p95(), u.anchor.clone())))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    };
    worst(&mut same.into_iter()).or_else(|| worst(&mut of()))
}

fn chart(title: &str, timed: &[Timed<'_>]) -> Plot {
    let mode = |t: &Timed<'_>| {
        t.bench.settings.get("mode").and_then(|m| m.as_str()).unwrap_or("other").to_owned()
    };
    let both: Vec<(usize, &Timed<'_>, f64)> = timed
        .iter()
        .enumerate()
        .filter_map(|(i, t)| t.error.as_ref().map(|(error, _)| (i, t, *error)))
        .collect();
    let series = unique(both.iter().map(|(_, t, _)| mode(t))).into_iter().map(|name| Series {
        joined: false,
        points: both
            .iter()
            .filter(|(_, t, _)| mode(t) == name)
            .map(|(i, t, error)| Point {
                at: [t.bench.median_ms, *error],
                spread: Some(t.bench.interval_ms),
                label: (i + 1).to_string(),
                note: format!(
                    "{}: {} ms, ΔE₀₀ p95 {}",
                    t.bench.variant,
                    figure(t.bench.median_ms),
                    figure(*error)
                ),
                link: t.anchor.clone(),
            })
            .collect(),
        name,
    });
    let places: Vec<[f64; 2]> =
        both.iter().map(|(_, t, error)| [t.bench.median_ms, *error]).collect();
    Plot {
        title: format!("Error against time: {title}"),
        x: PlotAxis { label: "median time of a frame, ms".into(), scale: Scale::Log },
        y: PlotAxis { label: "ΔE₀₀ p95".into(), scale: Scale::Log },
        series: series.collect(),
        dashed: front(&places),
    }
}

/// The variants on the front, fastest first.
fn best(timed: &[Timed<'_>]) -> Markup {
    let places = timed.iter().filter_map(|t| Some([t.bench.median_ms, t.error.as_ref()?.0]));
    let corners = front(&places.collect::<Vec<_>>());
    let is_on = |t: &&Timed<'_>| {
        t.error.as_ref().is_some_and(|(error, _)| corners.contains(&[t.bench.median_ms, *error]))
    };
    let mut on: Vec<&Timed<'_>> = timed.iter().filter(is_on).collect();
    on.sort_by(|a, b| a.bench.median_ms.total_cmp(&b.bench.median_ms));
    // a corner of the steps that is not a variant's point is worse than the corner after it
    on.dedup_by(|later, earlier| {
        let error = |t: &Timed<'_>| t.error.as_ref().map_or(f64::INFINITY, |(error, _)| *error);
        error(later) >= error(earlier)
    });
    html! {
        div {
            h4 { "On the front" }
            ol.best {
                @for t in on {
                    li value=(t.number) {
                        a href={ "#" (t.anchor) } { (t.bench.variant) }
                        span.dim {
                            (figure(t.bench.median_ms)) " ms"
                            @if let Some((error, _)) = &t.error { ", ΔE₀₀ p95 " (figure(*error)) }
                            @if let (Some(ratio), Some(baseline)) = (t.bench.ratio, &t.bench.baseline) {
                                ", " (figure(ratio)) "× as fast as " (baseline)
                            }
                        }
                    }
                }
            }
        }
    }
}

fn numbers(id: &str, title: &str, timed: &[Timed<'_>]) -> Markup {
    let rows: Vec<Row> = timed
        .iter()
        .enumerate()
        .map(|(i, t)| {
            let b = t.bench;
            let name = match &t.error {
                Some((_, anchor)) => html! { a href={ "#" (anchor) } { (b.variant) } },
                None => html! { (b.variant) },
            };
            let ratio = b.ratio.map_or_else(Cell::none, |ratio| {
                let interval = b
                    .ratio_interval
                    .map_or(String::new(), |[a, z]| format!(" ({}–{})", figure(a), figure(z)));
                Cell::shown(ratio, figure(ratio) + "×" + &interval)
            });
            let row = vec![
                Cell::count(i + 1),
                Cell::markup(name),
                Cell::maybe(t.error.as_ref().map(|(error, _)| *error)),
                Cell::shown(b.median_ms, format!("{} ± {}", figure(b.median_ms), figure(b.mad_ms))),
                ratio,
                b.baseline.as_ref().map_or_else(Cell::none, Cell::text),
                Cell::number(b.ns_per_pixel),
                Cell::maybe(b.ns_per_lookup),
                Cell::number(b.cpu_ms),
                Cell::number(b.pipeline_ms),
                Cell::shown(b.table_bytes as f64, number::bytes(b.table_bytes)),
                Cell::shown(
                    b.runs as f64,
                    format!("{} × {}, {} outliers", b.runs, b.frames_per_run, b.outliers),
                ),
                Cell::text(&b.clock),
            ];
            (Some(t.anchor.clone()), row)
        })
        .collect();
    let names = [
        "no.",
        "variant",
        "ΔE₀₀ p95",
        "median ± MAD, ms",
        "ratio (95 %)",
        "baseline",
        "ns per pixel",
        "ns per look-up",
        "CPU, ms",
        "pipeline, ms",
        "tables",
        "rounds × frames",
        "clock",
    ];
    table(id, &format!("Times: {title}"), &heads(names), &rows)
}
