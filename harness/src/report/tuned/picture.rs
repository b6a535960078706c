//! The front of a search as a separate SVG, for light and dark backgrounds.

use maud::{Markup, PreEscaped, html};

use super::mode;
use crate::report::merge::unique;
use crate::report::number::{self, figure};
use crate::report::plot::{self, Frame, PlotAxis, Point, Scale, class, front, mark, r};
use crate::results::{Tune, Verdict};

/// Width and height.
const SIZE: [f64; 2] = [960.0, 620.0];

/// Edges of the plot area: left, top, right, bottom.
const AREA: [f64; 4] = [78.0, 126.0, 930.0, 556.0];

/// The baseline is left out of the plot if it is this many times slower than the slowest other candidate.
const FAR: f64 = 3.0;

/// What this picture has beside the style of all drawings.
const STYLE: &str = "
svg { font: 13px system-ui, 'Segoe UI', Roboto, 'Helvetica Neue', sans-serif; }
.plot text { font-size: 13px; } .plot .dim { fill: var(--dim); } .plot .title { font-size: 20px; font-weight: 600; }
.paper { fill: var(--paper); } .within { fill: var(--good); opacity: .07; }
.budget { stroke: var(--good); stroke-width: 1.5; stroke-dasharray: 6 4; } .plot .good { fill: var(--good); font-weight: 600; }
.plot .front { stroke: var(--ink); stroke-dasharray: none; opacity: .45; }
.over .mark { fill: var(--paper); stroke: currentColor; stroke-width: 1.5; }
.ring { fill: none; stroke: var(--ink); stroke-width: 2; }
.plot .label { font-size: 12px; stroke-linejoin: round; } .plot .won .label { font-weight: 700; }
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
    let [along, up] = [axis("time of a pixel, ns"), axis("ΔE₀₀ p95, worst light")];
    let errors = placed.iter().map(|(_, at)| at[1]).chain([first.budget_de]);
    let frame = Frame::new(AREA, (&along, placed.iter().map(|(_, at)| at[0])), (&up, errors));
    let modes = unique(placed.iter().map(|(t, _)| mode(t)));
    let corners = front(&placed.iter().map(|(_, at)| *at).collect::<Vec<_>>());
    let budget = frame.y.place(first.budget_de);
    let lights: Vec<String> = first.lights.iter().map(|l| number::light(*l)).collect();
    let svg = html! {
        svg.plot xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (SIZE[0]) " " (SIZE[1]) } width=(SIZE[0]) height=(SIZE[1]) role="img"
            aria-label={ "Error against time of candidates for " (first.surface) } {
            style { (PreEscaped(plot::STYLE)) (PreEscaped(STYLE)) }
            rect.paper width="100%" height="100%" {}
            text.title x="24" y="38" { (first.surface) ": error against time" }
            text.dim x="24" y="60" { (first.backend) " " (first.adapter) ", " (first.size) " × " (first.size) " pixels; lights " (lights.join("; ")) }
            (legend(&modes))
            rect.within x=(left) y=(r(budget)) width=(right - left) height=(r((bottom - budget).max(0.0))) {}
            (frame.axes(&along, &up))
            @if let Some((_, at)) = texts { (ratios(&frame, at[0])) }
            @if let Some((_, [ns, p95])) = outside {
                text.dim x=(right - 6.0) y=(top + 20.0) text-anchor="end" { "texts: " (figure(ns)) " ns, p95 " (figure(p95)) " →" }
            }
            line.budget x1=(left) x2=(right) y1=(r(budget)) y2=(r(budget)) {}
            text.good x=(right - 6.0) y=(r(budget - 7.0)) text-anchor="end" { "budget " (number::plain(first.budget_de)) }
            polyline.front points=(frame.line(corners.into_iter())) {}
            (marks(&placed, &modes, &frame))
        }
    };
    Some(svg.into_string() + "\n")
}

/// A scale along the top: how many times as fast as the baseline.
fn ratios(frame: &Frame, texts_ns: f64) -> Markup {
    let [left, top, right, _] = AREA;
    let inside = |ratio: &f64| (left + 1.0..right - 1.0).contains(&frame.x.place(texts_ns / ratio));
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
        g.grid {
            @for ratio in ticks {
                @let at = r(frame.x.place(texts_ns / ratio));
                line x1=(at) x2=(at) y1=(top - 5.0) y2=(top) {}
                text x=(at) y=(top - 10.0) text-anchor="middle" { (number::plain(ratio)) "×" }
            }
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
            g class=(class(number)) { (mark(number, [at, 84.0])) }
            text x=(r(at + 12.0)) y="88.5" { (name) }
        }
    }
}

fn marks(placed: &[(&Tune, [f64; 2])], modes: &[String], frame: &Frame) -> Markup {
    let label = |t: &Tune| match (t.verdict, t.time) {
        (Verdict::Winner, Some(time)) => {
            // spaces make room for the ring
            format!("\u{a0}\u{a0}{}, {}× texts\u{a0}\u{a0}", t.variant, figure(time.ratio))
        }
        (Verdict::Baseline, _) => t.variant.clone(),
        _ if t.front => t.variant.clone(),
        _ => String::new(),
    };
    let point = |(t, at): &(&Tune, [f64; 2])| Point {
        at: *at,
        spread: None,
        label: label(t),
        note: format!("{}: {}", t.variant, t.verdict.words()),
        link: String::new(),
    };
    let points: Vec<Point> = placed.iter().map(point).collect();
    let beside = frame.labels(&points.iter().collect::<Vec<_>>(), AREA[2]);
    html! {
        @for (((tune, _), point), label) in placed.iter().zip(&points).zip(beside) {
            @let series = modes.iter().position(|m| *m == mode(tune)).unwrap_or(0);
            @let over = tune.worst_p95().is_some_and(|p95| p95 > tune.budget_de);
            @let won = tune.verdict == Verdict::Winner;
            g class={ (class(series)) @if over { " over" } @if won { " won" } } {
                (frame.dot(series, point, label))
                @if won {
                    @let [x, y] = frame.place(point.at);
                    circle.ring cx=(r(x)) cy=(r(y)) r="9" {}
                }
            }
        }
    }
}
