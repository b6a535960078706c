//! Plots as SVG inside the page, in the page's colours and font.
//!
//! The plot is narrow on purpose: its text stays readable on a phone. Series differ in colour, in the shape of their marks and
//! in a letter in the legend.

mod axis;
pub(super) mod labels;

use maud::{Markup, html};

pub(super) use axis::{Fitted, PlotAxis, Scale, fit};

/// Width and height of the plot, in its own units.
const SIZE: [f64; 2] = [440.0, 320.0];

/// Margins: left, top, right, bottom.
const MARGIN: [f64; 4] = [64.0, 14.0, 18.0, 46.0];

/// A plot.
pub(super) struct Plot {
    /// A description for screen readers.
    pub(super) title: String,
    /// The horizontal axis.
    pub(super) x: PlotAxis,
    /// The vertical axis.
    pub(super) y: PlotAxis,
    /// The series of points.
    pub(super) series: Vec<Series>,
    /// Corners of the step line through the front: points for which no other is smaller in both directions.
    pub(super) front: Vec<[f64; 2]>,
}

/// Points that belong together.
pub(super) struct Series {
    /// Name in the legend.
    pub(super) name: String,
    /// Whether its points are joined by a line.
    pub(super) joined: bool,
    /// The points.
    pub(super) points: Vec<Point>,
}

/// A point.
pub(super) struct Point {
    /// Its coordinates.
    pub(super) at: [f64; 2],
    /// Uncertainty along x: lower and upper end.
    pub(super) spread: Option<[f64; 2]>,
    /// The label beside it; may be empty.
    pub(super) label: String,
    /// The text shown when the pointer is over it.
    pub(super) note: String,
    /// Anchor of its data; may be empty.
    pub(super) link: String,
}

/// Draws a plot with its legend below.
pub(super) fn draw(plot: &Plot) -> Markup {
    let all = || plot.series.iter().flat_map(|s| &s.points);
    let x = fit(
        &plot.x,
        all().flat_map(|p| p.spread.unwrap_or([p.at[0]; 2]).into_iter().chain([p.at[0]])),
        [MARGIN[0], SIZE[0] - MARGIN[2]],
    );
    let y = fit(&plot.y, all().map(|p| p.at[1]), [SIZE[1] - MARGIN[3], MARGIN[1]]);
    let place = |at: [f64; 2]| [x.place(at[0]), y.place(at[1])];
    let marks: Vec<([f64; 2], &str)> = all().map(|p| (place(p.at), p.label.as_str())).collect();
    let mut beside =
        labels::arrange(&marks, [MARGIN[0], MARGIN[1], SIZE[0], SIZE[1] - MARGIN[3]]).into_iter();
    let (bottom, right) = (SIZE[1] - MARGIN[3], SIZE[0] - MARGIN[2]);
    html! {
        div.plot {
            svg viewBox={ "0 0 " (SIZE[0]) " " (SIZE[1]) } role="img" aria-label=(plot.title) {
                g.grid {
                    @for (at, text) in x.ticks() {
                        line x1=(r(*at)) x2=(r(*at)) y1=(MARGIN[1]) y2=(bottom) {}
                        text x=(r(*at)) y=(bottom + 16.0) text-anchor="middle" { (text) }
                    }
                    @for (at, text) in y.ticks() {
                        line x1=(MARGIN[0]) x2=(right) y1=(r(*at)) y2=(r(*at)) {}
                        text x=(MARGIN[0] - 7.0) y=(r(*at + 4.0)) text-anchor="end" { (text) }
                    }
                }
                text.axis x=((MARGIN[0] + right) / 2.0) y=(SIZE[1] - 8.0) text-anchor="middle" { (plot.x.label) }
                text.axis transform={ "translate(11 " (r((MARGIN[1] + bottom) / 2.0)) ") rotate(-90)" } text-anchor="middle" { (plot.y.label) }
                @if !plot.front.is_empty() {
                    polyline.front points=(points(plot.front.iter().map(|at| place(*at)))) {}
                }
                @for (number, series) in plot.series.iter().enumerate() {
                    g class={ "s" (number % MARKS) } {
                        @if series.joined {
                            polyline points=(points(series.points.iter().map(|p| place(p.at)))) {}
                        }
                        @for point in &series.points {
                            @let at = place(point.at);
                            @if let Some([from, to]) = point.spread {
                                line.spread x1=(r(x.place(from))) x2=(r(x.place(to))) y1=(r(at[1])) y2=(r(at[1])) {}
                            }
                            @let label = beside.next().flatten();
                            a href=[(!point.link.is_empty()).then(|| format!("#{}", point.link))] {
                                (mark(number, at))
                                title { (point.note) }
                                @if let Some([lx, ly]) = label {
                                    text.label x=(r(lx)) y=(r(ly)) text-anchor="middle" { (point.label) }
                                }
                            }
                        }
                    }
                }
            }
            @if plot.series.len() > 1 { (legend(&plot.series)) }
        }
    }
}

/// Number of marks and colours.
const MARKS: usize = 8;

fn legend(series: &[Series]) -> Markup {
    html! {
        ul.legend {
            @for (number, series) in series.iter().enumerate() {
                li {
                    svg viewBox="0 0 14 14" aria-hidden="true" {
                        g class={ "s" (number % MARKS) } { (mark(number, [7.0, 7.0])) }
                    }
                    @if series.joined { b { (letter(number)) } " " }
                    (series.name)
                }
            }
        }
    }
}

/// The letter of a series: a, b, …, z, aa, ab, ….
pub(super) fn letter(number: usize) -> String {
    let last = char::from(b'a' + (number % 26) as u8);
    match number / 26 {
        0 => last.to_string(),
        more => letter(more - 1) + &last.to_string(),
    }
}

/// A mark in the shape of the series.
pub(super) fn mark(series: usize, [x, y]: [f64; 2]) -> Markup {
    let path = match series % MARKS {
        0 => return html! { circle.mark cx=(r(x)) cy=(r(y)) r="4.2" {} },
        1 => "M-4,-4H4V4H-4Z",
        2 => "M0,-5L5,4H-5Z",
        3 => "M0,-5.4L5.4,0L0,5.4L-5.4,0Z",
        4 => "M0,5L5,-4H-5Z",
        5 => "M-5,-2H-2V-5H2V-2H5V2H2V5H-2V2H-5Z",
        6 => "M-5,-3.4L-3.4,-5L0,-1.6L3.4,-5L5,-3.4L1.6,0L5,3.4L3.4,5L0,1.6L-3.4,5L-5,3.4L-1.6,0Z",
        _ => "M-5.4,0L-2.7,-4.7H2.7L5.4,0L2.7,4.7H-2.7Z",
    };
    html! { path.mark d=(path) transform={ "translate(" (r(x)) " " (r(y)) ")" } {} }
}

fn points(places: impl Iterator<Item = [f64; 2]>) -> String {
    places.map(|[x, y]| format!("{},{}", r(x), r(y))).collect::<Vec<_>>().join(" ")
}

/// Rounds to a tenth of a unit, finer than any screen.
pub(super) fn r(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

/// Corners of the step line through the front, from the left. Smaller is better in both directions.
pub(super) fn front(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut corners: Vec<[f64; 2]> = Vec::new();
    for point in sorted {
        match corners.last().copied() {
            Some(last) if point[1] >= last[1] => {}
            Some(last) => corners.extend([[point[0], last[1]], point]),
            None => corners.push(point),
        }
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let front = front(&[[2.0, 3.0], [1.0, 5.0], [3.0, 4.0], [4.0, 1.0]]);
        assert_eq!(front, [[1.0, 5.0], [2.0, 5.0], [2.0, 3.0], [4.0, 3.0], [4.0, 1.0]]);
    }

    #[test]
    fn letters_go_on_after_z() {
        assert_eq!([letter(0), letter(25), letter(26), letter(53)], ["a", "z", "aa", "bb"]);
    }
}
