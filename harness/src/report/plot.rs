//! Plots as SVG inside the page, in the page's colours and font.
//!
//! The plot is narrow on purpose: its text stays readable on a phone. Series differ in colour, in the shape of their marks and
//! in a letter in the legend.

mod axis;
mod labels;

use maud::{Markup, html};

pub(super) use axis::{PlotAxis, Scale};

use axis::{Fitted, fit};
use labels::arrange;

/// Width and height of the plot, in its own units.
const SIZE: [f64; 2] = [440.0, 320.0];

/// Edges of the area of its points: left, top, right, bottom.
const AREA: [f64; 4] = [64.0, 14.0, 422.0, 274.0];

/// The colours and lines of drawings.
pub(super) const STYLE: &str = include_str!("plot/plot.css");

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
    /// Points of a dashed line, such as the corners of the step line through the [`front`].
    pub(super) dashed: Vec<[f64; 2]>,
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

/// An area with an axis below and an axis to its left.
pub(super) struct Frame {
    /// Its edges: left, top, right, bottom.
    area: [f64; 4],
    /// The axis to the right.
    pub(super) x: Fitted,
    /// The axis upwards.
    pub(super) y: Fitted,
}

impl Frame {
    /// Fits both axes to the values on them.
    pub(super) fn new(
        area: [f64; 4],
        x: (&PlotAxis, impl Iterator<Item = f64>),
        y: (&PlotAxis, impl Iterator<Item = f64>),
    ) -> Frame {
        let [left, top, right, bottom] = area;
        Frame { area, x: fit(x.0, x.1, [left, right]), y: fit(y.0, y.1, [bottom, top]) }
    }

    /// Where a point lies in the drawing.
    pub(super) fn place(&self, at: [f64; 2]) -> [f64; 2] {
        [self.x.place(at[0]), self.y.place(at[1])]
    }

    /// The points of a line, as SVG has them.
    pub(super) fn line(&self, points: impl Iterator<Item = [f64; 2]>) -> String {
        let places = points.map(|at| self.place(at)).map(|[x, y]| format!("{},{}", r(x), r(y)));
        places.collect::<Vec<_>>().join(" ")
    }

    /// The grid with the numbers at its lines, and what is on the axes.
    pub(super) fn axes(&self, x: &PlotAxis, y: &PlotAxis) -> Markup {
        let [left, top, right, bottom] = self.area;
        let middle = [0.5 * (left + right), 0.5 * (top + bottom)].map(r);
        html! {
            g.grid {
                @for (at, text) in self.x.ticks() {
                    line x1=(r(*at)) x2=(r(*at)) y1=(top) y2=(bottom) {}
                    text x=(r(*at)) y=(bottom + 16.0) text-anchor="middle" { (text) }
                }
                @for (at, text) in self.y.ticks() {
                    line x1=(left) x2=(right) y1=(r(*at)) y2=(r(*at)) {}
                    text x=(left - 7.0) y=(r(*at + 4.0)) text-anchor="end" { (text) }
                }
            }
            text.axis x=(middle[0]) y=(bottom + 38.0) text-anchor="middle" { (x.label) }
            text.axis transform={ "translate(" (left - 53.0) " " (middle[1]) ") rotate(-90)" } text-anchor="middle" { (y.label) }
        }
    }

    /// A point with its mark; `label` is where its label stands.
    pub(super) fn dot(&self, series: usize, point: &Point, label: Option<[f64; 2]>) -> Markup {
        let at = self.place(point.at);
        html! {
            @if let Some([from, to]) = point.spread {
                line.spread x1=(r(self.x.place(from))) x2=(r(self.x.place(to))) y1=(r(at[1])) y2=(r(at[1])) {}
            }
            a href=[(!point.link.is_empty()).then(|| format!("#{}", point.link))] {
                (mark(series, at))
                title { (point.note) }
                @if let Some([x, y]) = label {
                    text.label x=(r(x)) y=(r(y)) text-anchor="middle" { (point.label) }
                }
            }
        }
    }

    /// Where the labels of points stand, in the order of the points; inside the area, or up to `right`.
    pub(super) fn labels(&self, points: &[&Point], right: f64) -> Vec<Option<[f64; 2]>> {
        let marks: Vec<([f64; 2], &str)> =
            points.iter().map(|p| (self.place(p.at), p.label.as_str())).collect();
        let [left, top, _, bottom] = self.area;
        arrange(&marks, [left, top, right, bottom])
    }
}

/// Draws a plot, its legend below.
pub(super) fn draw(plot: &Plot) -> Markup {
    let all: Vec<&Point> = plot.series.iter().flat_map(|s| &s.points).collect();
    let along = all.iter().flat_map(|p| {
        let [from, to] = p.spread.unwrap_or([p.at[0]; 2]);
        [from, to, p.at[0]]
    });
    let frame = Frame::new(AREA, (&plot.x, along), (&plot.y, all.iter().map(|p| p.at[1])));
    let mut beside = frame.labels(&all, SIZE[0]).into_iter();
    html! {
        div.plot {
            svg viewBox={ "0 0 " (SIZE[0]) " " (SIZE[1]) } role="img" aria-label=(plot.title) {
                (frame.axes(&plot.x, &plot.y))
                @if !plot.dashed.is_empty() {
                    polyline.front points=(frame.line(plot.dashed.iter().copied())) {}
                }
                @for (number, series) in plot.series.iter().enumerate() {
                    g class=(class(number)) {
                        @if series.joined {
                            polyline points=(frame.line(series.points.iter().map(|p| p.at))) {}
                        }
                        @for point in &series.points {
                            (frame.dot(number, point, beside.next().flatten()))
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

/// The class of a series, which has its colour.
pub(super) fn class(series: usize) -> String {
    format!("s{}", series % MARKS)
}

/// The names of series with their marks.
pub(super) fn legend(series: &[Series]) -> Markup {
    html! {
        ul.legend {
            @for (number, series) in series.iter().enumerate() {
                li {
                    svg viewBox="0 0 14 14" aria-hidden="true" {
                        g class=(class(number)) { (mark(number, [7.0, 7.0])) }
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

/// A tenth of a unit is finer than any screen.
pub(super) fn r(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

/// Corners of the step line through the front, from the left: points for which no other is smaller in both directions.
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
