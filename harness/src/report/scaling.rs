//! Plots of time against a varied number.

use maud::{Markup, html};

use super::gap::nothing;
use super::merge::{Results, unique};
use super::number::{self, figure};
use super::plot::{Plot, PlotAxis, Point, Scale, Series, draw, letter};
use super::table::{self, Cell, Row, heads, table};
use crate::results::Scaling;

/// The section.
pub(super) fn section(results: &Results<'_>) -> Markup {
    if results.scalings.is_empty() {
        return nothing("no times against a varied number", "cargo xtask bench --scaling");
    }
    let places = unique(results.scalings.iter().map(|s| place(s)));
    html! {
        p { "Only the number on the horizontal axis changes. The exponent is the slope of a straight line through the logarithms: "
        "with 1, time is proportional to the number." }
        div.plots {
            @for (i, at) in places.iter().enumerate() {
                @let points: Vec<&Scaling> = results.scalings.iter().filter(|s| place(s) == *at).copied().collect();
                (one(i + 1, &points))
            }
        }
    }
}

fn place(s: &Scaling) -> (&str, &str, &str, &str) {
    (&s.axis, &s.surface, &s.backend, &s.adapter)
}

fn one(number: usize, points: &[&Scaling]) -> Markup {
    let Some(first) = points.first() else { return html! {} };
    let unit = match first.axis.as_str() {
        "pixels" => "pixels",
        "terms" => "terms of the series",
        "radius" => "radius of the window, bins",
        "wavelengths" => "wavelengths",
        "range" => "range of wavelengths, nm",
        "patch" => "width of the patch, µm",
        "height" => "peak to valley, nm",
        other => other,
    };
    let title = format!(
        "{} on {}:{}: time against {}",
        first.surface, first.backend, first.adapter, first.axis
    );
    let series: Vec<Series> = unique(points.iter().map(|s| s.variant.as_str()))
        .into_iter()
        .enumerate()
        .map(|(i, variant)| line(i, variant, points))
        .collect();
    let plot = Plot {
        title: title.clone(),
        x: PlotAxis { label: unit.into(), scale: Scale::Log },
        y: PlotAxis { label: "median time of a frame, ms".into(), scale: Scale::Log },
        series,
        dashed: Vec::new(),
    };
    let data = format!("scaling-{number}");
    let rows: Vec<Row> = points
        .iter()
        .map(|s| {
            let row = vec![
                Cell::text(&s.variant),
                Cell::shown(s.value, number::plain(s.value)),
                Cell::number(s.median_ms),
                Cell::number(s.mad_ms),
            ];
            (None, row)
        })
        .collect();
    html! {
        div.study {
            h3 { (title) }
            div.pair {
            (table::figure(&draw(&plot), &html! { "Median time of a frame against " (unit) ", both on logarithmic scales. " (exponents(&plot)) }, &data))
            (table(&data, &title, &heads(["variant", &first.axis, "median, ms", "MAD, ms"]), &rows))
            }
        }
    }
}

fn line(number: usize, variant: &str, points: &[&Scaling]) -> Series {
    let mut own: Vec<&Scaling> = points.iter().filter(|s| s.variant == variant).copied().collect();
    own.sort_by(|a, b| a.value.total_cmp(&b.value));
    let last = own.len().saturating_sub(1);
    let point = |(i, s): (usize, &&Scaling)| Point {
        at: [s.value, s.median_ms],
        spread: None,
        label: if i == last { letter(number) } else { String::new() },
        note: format!(
            "{variant}: {} at {}, {} ms",
            s.axis,
            number::plain(s.value),
            figure(s.median_ms)
        ),
        link: String::new(),
    };
    Series {
        name: variant.to_owned(),
        joined: true,
        points: own.iter().enumerate().map(point).collect(),
    }
}

fn exponents(plot: &Plot) -> Markup {
    let fits: Vec<String> = plot
        .series
        .iter()
        .filter_map(|s| {
            let places: Vec<[f64; 2]> = s.points.iter().map(|p| p.at).collect();
            exponent(&places).map(|e| format!("{}: {e:.2}", s.name))
        })
        .collect();
    html! { @if !fits.is_empty() { "Exponents: " (fits.join("; ")) "." } }
}

/// Slope of the least-squares line through the logarithms.
fn exponent(points: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> =
        points.iter().filter(|p| p[0] > 0.0 && p[1] > 0.0).map(|p| p.map(f64::ln)).collect();
    let count = logs.len() as f64;
    let mean = |axis: usize| logs.iter().map(|p| p[axis]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let spread: f64 = logs.iter().map(|p| (p[0] - x).powi(2)).sum();
    let joint: f64 = logs.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    (spread > 0.0).then(|| joint / spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_has_its_exponent() {
        let points = [1.0, 2.0, 5.0, 9.0].map(|x: f64| [x, 3.0 * x.powf(1.5)]);
        assert!(exponent(&points).is_some_and(|e| (e - 1.5).abs() < 1e-12));
        assert_eq!(exponent(&points[..1]), None);
    }
}
