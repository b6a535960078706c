//! Periods of surfaces as variants show them.

use maud::{Markup, html};

use super::album::{Picture, shown};
use super::gap::nothing;
use super::merge::{Results, unique};
use super::number::figure;
use super::plot::{Plot, PlotAxis, Point, Scale, Series, draw, letter};
use super::table::{self, Cell, Head, Row, heads, table};
use crate::results::Testbench;

/// Mean and standard deviation in nm that the thesis publishes, by surface and mode.
const PUBLISHED: [(&str, &str, f64, f64); 7] = [
    ("blazed", "full", 2499.997, 0.377),
    ("blazed", "adaptive", 2499.997, 0.377),
    ("blazed", "pq", 2502.428, 0.390),
    ("elaphe", "full", 1144.262, 0.401),
    ("elaphe", "adaptive", 1144.179, 0.677),
    ("elaphe", "pq", 1052.3, 49.7),
    ("xenopeltis", "full", 1552.27, 0.45),
];

/// Angle of incidence in degrees and true period of the grating in nm, for the published numbers.
const PUBLISHED_AT: (f64, f64) = (75.0, 2500.0);

/// The section.
pub(super) fn section(results: &Results<'_>) -> Markup {
    html! {
        @if results.periods.is_empty() {
            (nothing("no periods", "cargo xtask testbench --json"))
        } @else {
            p {
                "For each wavelength, the angle of the strongest response gives a period by the grating equation, first order. Mean and "
                "standard deviation are over wavelengths. Gratings are compared with the same estimator on their closed form, since the "
                "efficiency of an order shifts its peak a little away from the grating equation, rightly so."
            }
            (whole(results))
            (windows(results))
            (not_applicable(results))
            (responses(results))
        }
        h3 { "Published periods" }
        (published())
    }
}

fn whole(results: &Results<'_>) -> Markup {
    let all: Vec<&Testbench> = results
        .periods
        .iter()
        .map(|(t, _)| *t)
        .filter(|t| t.window.is_none() && t.windows.is_none())
        .collect();
    if all.is_empty() {
        return html! { p.nothing { "Nothing recorded: no period of a whole surface." } };
    }
    let exact = |t: &Testbench| {
        all.iter().find(|e| e.variant == "exact" && place(e) == place(t)).map(|e| e.period_nm)
    };
    let away = |period: f64, from: Option<f64>| {
        from.map_or_else(Cell::none, |from| {
            Cell::shown(period - from, format!("{:+.3}", period - from))
        })
    };
    let rows: Vec<Row> = all
        .iter()
        .map(|t| {
            let published = published_for(results, t);
            let row = vec![
                Cell::text(&t.variant),
                Cell::text(&t.surface),
                Cell::text(&t.route),
                angle(t),
                nm(t.period_nm),
                nm(t.sd_nm),
                away(t.period_nm, t.closed_nm.map(|c| c[0])),
                away(t.period_nm, exact(t).filter(|_| t.variant != "exact")),
                nm(t.expected_nm),
                away(t.period_nm, Some(t.expected_nm)),
                t.closed_nm.map_or_else(Cell::none, |c| {
                    Cell::shown(c[0], format!("{:.3} / {:.3}", c[0], c[1]))
                }),
                published.map_or_else(Cell::none, |(mean, sd)| {
                    Cell::shown(mean, format!("{mean} / {sd}"))
                }),
                Cell::shown(t.points as f64, format!("{}{}", t.points, left_out(t))),
            ];
            (None, row)
        })
        .collect();
    let heads = [
        ("variant", ""),
        ("surface", ""),
        ("route", "what computed the response"),
        ("θi", "angle of incidence"),
        ("period, nm", "mean period over wavelengths"),
        ("sd, nm", "standard deviation over wavelengths"),
        ("− closed form", "difference from the same estimator on the grating's closed form"),
        ("− exact", "difference from the same estimator on the exact reference"),
        ("given, nm", "the grating's period, or the expected period"),
        ("− given", "difference from the given period"),
        ("closed form, nm", "mean / sd of the same estimator on the closed form"),
        ("published, nm", "mean / sd in the thesis"),
        ("wavelengths", "number with a peak; e: first order evanescent, f: no maximum"),
    ];
    let heads = heads.map(|(name, hint)| Head(name.into(), hint));
    table("periods-whole", "Periods of whole surfaces", &heads, &rows)
}

fn place(t: &Testbench) -> (&str, f64, f64) {
    (&t.surface, t.theta_i, t.phi_i)
}

fn nm(value: f64) -> Cell {
    Cell::shown(value, format!("{value:.3}"))
}

fn angle(t: &Testbench) -> Cell {
    Cell::shown(t.theta_i, super::number::light([t.theta_i, t.phi_i]))
}

fn left_out(t: &Testbench) -> String {
    let part = |count: usize, sign: &str| {
        if count > 0 { format!(", {count}{sign}") } else { String::new() }
    };
    part(t.evanescent, "e") + &part(t.flat, "f")
}

/// The published numbers for a surface of this name, by the variant's mode, at their angle and for a grating of their period.
fn published_for(results: &Results<'_>, t: &Testbench) -> Option<(f64, f64)> {
    let known =
        results.units.iter().find(|u| u.variant == t.variant).and_then(|u| u.setting("mode"));
    let mode = known.unwrap_or(match t.variant.as_str() {
        "texts" | "exact" => "full",
        name => name.split('-').next().unwrap_or_default(),
    });
    let name = t.surface.to_lowercase();
    PUBLISHED
        .iter()
        .find(|(surface, m, ..)| name.contains(surface) && *m == mode)
        .filter(|_| (t.theta_i - PUBLISHED_AT.0).abs() < 0.5)
        .filter(|(surface, ..)| {
            *surface != "blazed" || (t.expected_nm / PUBLISHED_AT.1 - 1.0).abs() < 0.01
        })
        .map(|(_, _, mean, sd)| (*mean, *sd))
}

fn windows(results: &Results<'_>) -> Markup {
    let of = |single: bool| -> Vec<&Testbench> {
        let is = |t: &&Testbench| if single { t.window.is_some() } else { t.windows.is_some() };
        results.periods.iter().map(|(t, _)| *t).filter(is).collect()
    };
    let (single, summaries) = (of(true), of(false));
    if single.is_empty() && summaries.is_empty() {
        return html! {};
    }
    let together: Vec<Row> = summaries
        .iter()
        .map(|t| {
            let (count, spread) = t.windows.unwrap_or_default();
            let published = published_for(results, t);
            let row = vec![
                Cell::text(&t.variant),
                Cell::text(&t.surface),
                angle(t),
                Cell::count(count),
                nm(t.period_nm),
                nm(spread),
                nm(t.sd_nm),
                published.map_or_else(Cell::none, |(mean, sd)| {
                    Cell::shown(mean, format!("{mean} / {sd}"))
                }),
            ];
            (None, row)
        })
        .collect();
    let rows: Vec<Row> = single
        .iter()
        .map(|t| {
            let [column, row, width, height] = t.window.unwrap_or_default();
            let cells = vec![
                Cell::text(&t.variant),
                Cell::text(&t.surface),
                angle(t),
                Cell::text(format!("{column}, {row}")),
                Cell::text(format!("{width} × {height}")),
                nm(t.period_nm),
                nm(t.sd_nm),
                Cell::shown(t.points as f64, format!("{}{}", t.points, left_out(t))),
                Cell::number(t.weight),
            ];
            (None, cells)
        })
        .collect();
    let data = if single.is_empty() { "windows" } else { "windows-each" };
    html! {
        h3 { "Windows of scans" }
        @if !together.is_empty() {
            (table("windows", "Means over windows of a scan, weighted by their response", &heads([
                "variant", "surface", "θi", "windows", "period, nm", "spread between windows, nm", "sd over wavelengths, nm", "published, nm",
            ]), &together))
        }
        @for (i, surface) in unique(single.iter().map(|t| t.surface.as_str())).into_iter().enumerate() {
            @let own: Vec<&Testbench> = single.iter().filter(|t| t.surface == surface).copied().collect();
            @let caption = html! { "Periods of the windows of " b { (surface) } ", one mark for each." };
            div.pair {
                (table::figure(&draw(&scatter(surface, &own)), &caption, data))
                @if i == 0 {
                    (table("windows-each", "Each window", &heads([
                        "variant", "surface", "θi", "first pixel", "pixels", "period, nm", "sd, nm", "wavelengths", "response",
                    ]), &rows))
                }
            }
        }
    }
}

fn scatter(surface: &str, own: &[&Testbench]) -> Plot {
    let variants = unique(own.iter().map(|t| t.variant.as_str()));
    let series = variants.iter().enumerate().map(|(i, variant)| Series {
        name: format!("{}: {variant}", letter(i)),
        joined: false,
        points: own
            .iter()
            .filter(|t| t.variant == *variant)
            .map(|t| Point {
                at: [i as f64, t.period_nm],
                spread: None,
                label: String::new(),
                note: format!("{variant}: {} nm, sd {} nm", figure(t.period_nm), figure(t.sd_nm)),
                link: String::new(),
            })
            .collect(),
    });
    Plot {
        title: format!("Periods of the windows of {surface}"),
        x: PlotAxis {
            label: "variant".into(),
            scale: Scale::Names((0..variants.len()).map(letter).collect()),
        },
        y: PlotAxis { label: "period, nm".into(), scale: Scale::Linear },
        series: series.collect(),
        dashed: Vec::new(),
    }
}

fn not_applicable(results: &Results<'_>) -> Markup {
    let rows: Vec<Row> = results
        .gaps
        .iter()
        .filter(|gap| gap.reason.starts_with("not applicable"))
        .map(|gap| {
            let name = |name: &Option<String>| name.as_ref().map_or_else(Cell::none, Cell::text);
            (None, vec![name(&gap.variant), name(&gap.surface), Cell::prose(&gap.reason)])
        })
        .collect();
    html! {
        @if !rows.is_empty() {
            h3 { "Not applicable" }
            (table("not-applicable", "Variants without a period here", &heads(["variant", "surface", "reason"]), &rows))
        }
    }
}

fn responses(results: &Results<'_>) -> Markup {
    let drawn: Vec<(&Testbench, &Picture)> =
        results.periods.iter().filter_map(|(t, p)| p.as_ref().map(|p| (*t, p))).collect();
    html! {
        @if !drawn.is_empty() {
            h3 { "Responses" }
            div.responses {
                @for (t, picture) in drawn {
                    @let what = format!("{} on {}, {}", t.variant, t.surface, super::number::light([t.theta_i, t.phi_i]));
                    @let data = if t.window.is_some() { "windows-each" } else { "periods-whole" };
                    @let caption = html! {
                        b { (what) } @if let Some([c, r, w, h]) = t.window { ", window " (w) " × " (h) " at " (c) ", " (r) }
                        ": response over wavelength and viewing angle, with the curve of the grating equation."
                    };
                    (table::figure(&shown(picture, &format!("Response: {what}"), "response"), &caption, data))
                }
            }
        }
    }
}

fn published() -> Markup {
    let rows: Vec<Row> = PUBLISHED
        .iter()
        .map(|(surface, mode, mean, sd)| {
            let cells = [Cell::text(surface), Cell::text(mode)];
            let numbers = [*mean, *sd].map(|v| Cell::shown(v, format!("{v}")));
            (None, cells.into_iter().chain(numbers).collect())
        })
        .collect();
    html! {
        p.note {
            "Source: the evaluation in the thesis that this work began with, θi 75°, φi 0°. Its standard deviation is printed there as "
            "variance. The blazed grating has 2500 nm. The numbers of the skins come from one crop each, and all numbers from w = +1 "
            "and a grid of 0.01°: with the right w, the Elaphe period is between 1044 and 1183 nm, depending on the crop. The values "
            "measured here are independent of them."
        }
        (table("published", "Published periods", &heads(["surface", "mode", "mean, nm", "sd, nm"]), &rows))
    }
}
