//! The front of a search as a separate SVG, for light and dark backgrounds.

use maud::{Markup, PreEscaped, html};

use super::mode;
use crate::report::merge::unique;
use crate::report::number::{self, figure};
use crate::report::plot::labels::arrange;
use crate::report::plot::{Fitted, PlotAxis, Scale, fit, front, mark, r};
use crate::results::{Tune, Verdict};

/// Width and height.
const SIZE: [f64; 2] = [960.0, 620.0];

/// Edges of the plot area: left, top, right, bottom.
const AREA: [f64; 4] = [78.0, 126.0, 930.0, 556.0];

/// The baseline is left out of the plot if it is this many times slower than the slowest other candidate.
const FAR: f64 = 3.0;

const STYLE: &str = "
svg { color-scheme: light dark; font: 13px system-ui, 'Segoe UI', Roboto, 'Helvetica Neue', sans-serif;
  --paper: #fcfbf9; --ink: #1d1c1a; --dim: #66625b; --rule: #e3dfd7; --good: #00664a;
  --c0: #0072b2; --c1: #c04f00; --c2: #00805c; --c3: #a8477f; --c4: #8a6d00; --c5: #2b8cbe; --c6: #4a4a4a; --c7: #6a51a3; }
@media (prefers-color-scheme: dark) { svg { --paper: #131518; --ink: #e9e7e2; --dim: #a19d95; --rule: #2e3238; --good: #5fd0ab;
  --c0: #56a8e8; --c1: #f08c4a; --c2: #35c79b; --c3: #df94be; --c4: #e6c229; --c5: #8fd3f4; --c6: #c9c9c9; --c7: #b3a2e6; } }
.paper { fill: var(--paper); } text { fill: var(--ink); } .dim { fill: var(--dim); }
.title { font-size: 20px; font-weight: 600; } .grid { stroke: var(--rule); }
.within { fill: var(--good); opacity: .07; } .budget { stroke: var(--good); stroke-width: 1.5; stroke-dasharray: 6 4; }
.good { fill: var(--good); font-weight: 600; }
.front { fill: none; stroke: var(--ink); stroke-width: 1.5; opacity: .45; }
.s0 { --c: var(--c0); } .s1 { --c: var(--c1); } .s2 { --c: var(--c2); } .s3 { --c: var(--c3); }
.s4 { --c: var(--c4); } .s5 { --c: var(--c5); } .s6 { --c: var(--c6); } .s7 { --c: var(--c7); }
.mark { fill: var(--c); stroke: var(--c); stroke-width: 1.5; } .over .mark { fill: var(--paper); }
.ring { fill: none; stroke: var(--ink); stroke-width: 2; }
.label { font-size: 12px; paint-order: stroke; stroke: var(--paper); stroke-width: 4px; stroke-linejoin: round; }
.won { font-weight: 700; }
";

/// Plots error against time of the candidates of one search that have both; `None` if there are no such candidates.
pub fn front_picture(records: &[Tune]) -> Option<String> {
    let mut placed: Vec<(&Tune, [f64; 2])> =
        records.iter().filter_map(|t| Some((t, t.place()?))).collect();
    let first = records.first()?;
    // labels are placed in this order: the first ones get room
    let rank = |t: &Tune| match t.verdict {
        Verdict::Winner => 0,
        Verdict::Baseline => 1,
        _ if t.front => 2,
        _ => 3,
    };
    placed.sort_by(|a, b| rank(a.0).cmp(&rank(b.0)).then(a.1[0].total_cmp(&b.1[0])));
    if placed.is_empty() {
        return None;
    }
    let [left, top, right, bottom] = AREA;
    // with the baseline, all other points would be pushed to one side
    let texts = placed.iter().find(|(t, _)| t.verdict == Verdict::Baseline).copied();
    let slowest = |placed: &[(&Tune, [f64; 2])]| placed.iter().map(|p| p.1[0]).fold(0.0, f64::max);
    let others: Vec<_> =
        placed.iter().filter(|(t, _)| t.verdict != Verdict::Baseline).copied().collect();
    let outside = texts.filter(|(_, at)| !others.is_empty() && at[0] > FAR * slowest(&others));
    if outside.is_some() {
        placed = others;
    }
    let axis = |label: &str| PlotAxis { label: label.to_owned(), scale: Scale::Log };
    let x = fit(&axis("ns per pixel"), placed.iter().map(|(_, at)| at[0]), [left, right]);
    let errors = placed.iter().map(|(_, at)| at[1]).chain([first.budget_de]);
    let y = fit(&axis("ΔE₀₀ p95"), errors, [bottom, top]);
    let modes = unique(placed.iter().map(|(t, _)| mode(t)));
    let corners = front(&placed.iter().map(|(_, at)| *at).collect::<Vec<_>>());
    let place = |at: [f64; 2]| [x.place(at[0]), y.place(at[1])];
    let corners: Vec<String> =
        corners.iter().map(|at| place(*at)).map(|[x, y]| format!("{},{}", r(x), r(y))).collect();
    let budget = y.place(first.budget_de);
    let lights: Vec<String> = first.lights.iter().map(|l| number::light(*l)).collect();
    let svg = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (SIZE[0]) " " (SIZE[1]) } width=(SIZE[0]) height=(SIZE[1]) role="img"
            aria-label={ "Error against time of candidates for " (first.surface) } {
            style { (PreEscaped(STYLE)) }
            rect.paper width="100%" height="100%" {}
            text.title x="24" y="38" { (first.surface) ": error against time" }
            text.dim x="24" y="60" { (first.backend) " " (first.adapter) ", " (first.size) " × " (first.size) " pixels; lights " (lights.join("; ")) }
            (legend(&modes))
            rect.within x=(left) y=(r(budget)) width=(right - left) height=(r((bottom - budget).max(0.0))) {}
            (grid(&x, &y))
            @if let Some((_, at)) = texts { (ratios(&x, at[0])) }
            @if let Some((_, [ns, p95])) = outside {
                text.dim x=(right - 6.0) y=(top + 20.0) text-anchor="end" { "texts: " (figure(ns)) " ns, p95 " (figure(p95)) " →" }
            }
            line.budget x1=(left) x2=(right) y1=(r(budget)) y2=(r(budget)) {}
            text.good x=(right - 6.0) y=(r(budget - 7.0)) text-anchor="end" { "budget " (number::plain(first.budget_de)) }
            text x=((left + right) / 2.0) y=(bottom + 46.0) text-anchor="middle" { "time of a pixel, ns" }
            text transform={ "translate(24 " ((top + bottom) / 2.0) ") rotate(-90)" } text-anchor="middle" { "ΔE₀₀ p95, worst light" }
            polyline.front points=(corners.join(" ")) {}
            (marks(&placed, &modes, &x, &y))
        }
    };
    Some(svg.into_string() + "\n")
}

fn grid(x: &Fitted, y: &Fitted) -> Markup {
    let [left, top, right, bottom] = AREA;
    html! {
        @for (at, text) in x.ticks() {
            line.grid x1=(r(*at)) x2=(r(*at)) y1=(top) y2=(bottom) {}
            text.dim x=(r(*at)) y=(bottom + 20.0) text-anchor="middle" { (text) }
        }
        @for (at, text) in y.ticks() {
            line.grid x1=(left) x2=(right) y1=(r(*at)) y2=(r(*at)) {}
            text.dim x=(left - 10.0) y=(r(*at + 4.5)) text-anchor="end" { (text) }
        }
    }
}

/// A scale along the top: the ratio to the baseline's time.
fn ratios(x: &Fitted, texts_ns: f64) -> Markup {
    let [left, top, right, _] = AREA;
    let inside = |ratio: &f64| (left + 1.0..right - 1.0).contains(&x.place(texts_ns / ratio));
    let of = |multiples: &[f64]| -> Vec<f64> {
        let all = (-1..=6).flat_map(|e| multiples.iter().map(move |m| m * 10_f64.powi(e)));
        all.filter(inside).collect()
    };
    // as many as fit
    let steps: [&[f64]; 3] =
        [&[1.0], &[1.0, 2.0, 5.0], &[1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0]];
    let ticks = steps.into_iter().map(of).find(|ticks| ticks.len() > 2);
    let ticks = ticks.unwrap_or_else(|| of(steps[2]));
    html! {
        @for ratio in ticks {
            @let at = r(x.place(texts_ns / ratio));
            line.grid x1=(at) x2=(at) y1=(top - 5.0) y2=(top) {}
            text.dim x=(at) y=(top - 10.0) text-anchor="middle" { (number::plain(ratio)) "×" }
        }
        text.dim x=(right) y=(top - 28.0) text-anchor="end" { "times as fast as texts" }
    }
}

fn legend(modes: &[String]) -> Markup {
    let widths = modes.iter().map(|name| 34.0 + 7.0 * name.chars().count() as f64);
    let starts: Vec<f64> = widths
        .scan(30.0, |at, width| {
            *at += width;
            Some(*at - width)
        })
        .collect();
    html! {
        @for (number, (name, at)) in modes.iter().zip(starts).enumerate() {
            g class={ "s" (number % 8) } { (mark(number, [at, 84.0])) }
            text x=(r(at + 12.0)) y="88.5" { (name) }
        }
    }
}

fn marks(placed: &[(&Tune, [f64; 2])], modes: &[String], x: &Fitted, y: &Fitted) -> Markup {
    let place = |at: [f64; 2]| [x.place(at[0]), y.place(at[1])];
    let label = |t: &Tune| match (t.verdict, t.time) {
        (Verdict::Winner, Some(time)) => {
            // spaces make room for the ring
            format!("\u{a0}\u{a0}{}, {}× texts\u{a0}\u{a0}", t.variant, figure(time.ratio))
        }
        (Verdict::Baseline, _) => t.variant.clone(),
        _ if t.front => t.variant.clone(),
        _ => String::new(),
    };
    let texts: Vec<([f64; 2], String)> =
        placed.iter().map(|(t, at)| (place(*at), label(t))).collect();
    let texts: Vec<([f64; 2], &str)> =
        texts.iter().map(|(at, text)| (*at, text.as_str())).collect();
    let beside = arrange(&texts, AREA);
    html! {
        @for ((tune, _), ([px, py], _)) in placed.iter().zip(&texts) {
            @let series = modes.iter().position(|m| *m == mode(tune)).unwrap_or(0);
            @let over = tune.worst_p95().is_some_and(|p95| p95 > tune.budget_de);
            g class={ "s" (series % 8) @if over { " over" } } {
                title { (tune.variant) ": " (tune.verdict.words()) }
                (mark(series, [*px, *py]))
            }
        }
        @for ((tune, _), ((_, text), at)) in placed.iter().zip(texts.iter().zip(beside)) {
            @if let Some([lx, ly]) = at {
                text class={ "label" @if tune.verdict == Verdict::Winner { " won" } } x=(r(lx)) y=(r(ly)) text-anchor="middle" { (text) }
            }
        }
        @for ((tune, _), ([px, py], _)) in placed.iter().zip(&texts) {
            @if tune.verdict == Verdict::Winner { circle.ring cx=(r(*px)) cy=(r(*py)) r="9" {} }
        }
    }
}
