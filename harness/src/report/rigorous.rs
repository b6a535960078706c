//! The limits of the model: its efficiencies beside those of a rigorous solver. They are the same in every report.

use std::iter;

use diffraction_shaders::field::rigorous::{Solved, SolvedOrder, WEAK, solved};
use diffraction_shaders::plan::Obliquity;
use maud::{Markup, html};

use super::number::{figure, plain};
use super::plot::{Frame, Plot, PlotAxis, Point, Scale, Series, class, draw, legend};
use super::table::{self, Cell, Head, Row, table};

/// Anchor of the table.
const DATA: &str = "rigorous-data";

/// Flatter reliefs, µm, are not drawn: they test the cover, and their light is in the mirror order.
const FLAT_UM: f64 = 0.05;

/// Direction of the light and wavelength at which single orders are drawn.
const THETA_DEG: f64 = 30.0;
const LAMBDA_NM: f64 = 550.0;

/// Width and height of a drawing of orders, and the edges of its area.
const SIZE: [f64; 2] = [340.0, 240.0];
const AREA: [f64; 4] = [58.0, 12.0, 332.0, 196.0];

/// The section.
pub(super) fn section() -> Markup {
    let gratings = match solved() {
        Ok(gratings) => gratings,
        Err(error) => return html! { p.nothing { (error) } },
    };
    let drawn: Vec<&Solved> = gratings.iter().filter(|g| g.height_um > FLAT_UM).collect();
    let caption = html! {
        b { "Scalar against rigorous efficiency" } " of every order above " (plain(WEAK)) ", in unpolarised light, at 0°, 30° and 60°, at 450, 550 and 650 nm. On the dashed line both are equal."
    };
    html! {
        p { "What the comparisons above cannot show: the exact reference is a scalar theory, with one phase per point and one reflection. Here its efficiencies of "
        "gratings are beside those of a rigorous solver (boundary integrals), inside the cover. These numbers do not depend on this report's records." }
        p { "Directions of orders are always right. Their light is right on shallow and wide reliefs such as the shallow holographic grating, roughly right on a CD and a DVD, and wrong on reliefs that are "
        "deeper or finer: do not trust colours there." }
        div.pair {
            (table::figure(&draw(&scatter(&drawn)), &caption, DATA))
            (numbers(&gratings))
        }
        details {
            summary { "Orders of each grating at " (plain(THETA_DEG)) "° and " (plain(LAMBDA_NM)) " nm" }
            div.plot { (legend(&CURVES.map(|(name, ..)| Series { name: name.to_owned(), joined: false, points: Vec::new() }))) }
            div.more { @for grating in &drawn { (orders(grating)) } }
        }
    }
}

/// A name within anchors.
fn anchor(grating: &Solved) -> String {
    format!("rigorous-{}", grating.name.replace(' ', "-"))
}

/// The number of an order.
fn signed(order: &SolvedOrder) -> String {
    order.order.to_string().replace('-', "−")
}

/// Profile, size and matter in a few words.
fn relief(grating: &Solved) -> String {
    let Solved { profile, period_um, height_um, duty, metal, .. } = grating;
    let duty = duty.map_or_else(String::new, |duty| format!(", duty {duty}"));
    let metal = if metal == "perfect" { "perfect conductor" } else { metal };
    let indices = || grating.orders.iter().map(|order| order.cover_index);
    let least = indices().fold(f64::INFINITY, f64::min);
    let greatest = indices().fold(0.0, f64::max);
    let above = match greatest {
        1.0 => "in air".to_owned(),
        _ if least == greatest => format!("under index {least:.2}"),
        _ => format!("under index {least:.2} to {greatest:.2}"),
    };
    format!("{profile}, {period_um} µm, height {height_um} µm{duty}, {metal} {above}")
}

fn numbers(gratings: &[Solved]) -> Markup {
    let row = |grating: &Solved| -> Row {
        let three = |value: f64| Cell::shown(value, format!("{value:.3}"));
        let both = grating.departure(Obliquity::Stam);
        let name = html! { (grating.name) br; small { (relief(grating)) } };
        let mut cells =
            vec![Cell::lines(name), Cell::count(both.count), three(both.worst), three(both.mean)];
        let polarised = [Obliquity::Te, Obliquity::Tm];
        cells.extend(polarised.map(|of| three(grating.departure(of).worst)));
        (Some(anchor(grating)), cells)
    };
    let rows: Vec<Row> = gratings.iter().map(row).collect();
    let heads = [
        ("grating", ""),
        ("orders", "those to which the solver gives more than 0.01"),
        ("worst", "greatest difference in unpolarised light, obliquity \"stam\""),
        ("mean", "mean difference in unpolarised light, obliquity \"stam\""),
        ("TE worst", "electric field along the grooves, obliquity \"te\""),
        ("TM worst", "magnetic field along the grooves, obliquity \"tm\""),
    ];
    let heads = heads.map(|(name, hint)| Head(name.to_owned(), hint));
    table(DATA, "Difference of scalar and rigorous efficiency", &heads, &rows)
}

fn scatter(gratings: &[&Solved]) -> Plot {
    let points = |grating: &Solved| {
        let strong = |order: &&SolvedOrder| order.efficiencies(Obliquity::Stam)[0] > WEAK;
        let point = |order: &SolvedOrder| {
            let at = order.efficiencies(Obliquity::Stam);
            let place = format!("{}°, {} nm", order.theta_i_deg, order.wavelength_nm);
            let [rigorous, scalar] = at.map(figure);
            Point {
                at,
                spread: None,
                label: String::new(),
                note: format!(
                    "{}, {place}, order {}: rigorous {rigorous}, scalar {scalar}",
                    grating.name,
                    signed(order)
                ),
                link: anchor(grating),
            }
        };
        grating.orders.iter().filter(strong).map(point).collect()
    };
    let series = gratings.iter().map(|grating| Series {
        name: grating.name.clone(),
        joined: false,
        points: points(grating),
    });
    let series: Vec<Series> = series.collect();
    let rigorous = series.iter().flat_map(|s| &s.points).map(|point| point.at[0]);
    // within the plot, which would bend a longer line
    let end = rigorous.fold(0.0, f64::max);
    Plot {
        title: "Scalar against rigorous efficiency".into(),
        x: PlotAxis { label: "rigorous efficiency".into(), scale: Scale::Linear },
        y: PlotAxis { label: "scalar efficiency".into(), scale: Scale::Linear },
        series,
        dashed: vec![[0.0; 2], [end; 2]],
    }
}

/// What is drawn of each order: name, light, and which of the two efficiencies.
const CURVES: [(&str, Obliquity, usize); 3] = [
    ("rigorous, TE", Obliquity::Te, 0),
    ("rigorous, TM", Obliquity::Tm, 0),
    ("scalar, unpolarised", Obliquity::Stam, 1),
];

/// Efficiencies over the orders of a grating.
fn orders(grating: &Solved) -> Markup {
    let here = grating
        .orders
        .iter()
        .filter(|order| (order.theta_i_deg, order.wavelength_nm) == (THETA_DEG, LAMBDA_NM));
    let mut here: Vec<&SolvedOrder> = here.collect();
    here.sort_by_key(|order| order.order);
    let names = here.iter().map(|order| signed(order)).collect();
    let x = PlotAxis { label: "order".into(), scale: Scale::Names(names) };
    let y = PlotAxis { label: "efficiency".into(), scale: Scale::Linear };
    let curves = CURVES.map(|(name, of, which)| {
        let point = |(i, order): (usize, &&SolvedOrder)| {
            let value = order.efficiencies(of)[which];
            Point {
                at: [i as f64, value],
                spread: None,
                label: String::new(),
                note: format!("order {}, {name}: {}", signed(order), figure(value)),
                link: String::new(),
            }
        };
        here.iter().enumerate().map(point).collect::<Vec<_>>()
    });
    let heights = curves.iter().flatten().map(|point| point.at[1]).chain(iter::once(0.0));
    let places = (0..here.len()).map(|i| i as f64);
    let frame = Frame::new(AREA, (&x, places), (&y, heights));
    let [width, height] = SIZE;
    html! {
        figure {
            div.plot {
                svg viewBox={ "0 0 " (width) " " (height) } role="img" aria-label={ "Efficiencies of orders: " (grating.name) } {
                    (frame.axes(&x, &y))
                    // the line below the marks
                    @for (number, points) in curves.iter().enumerate().rev() {
                        g class=(class(number)) {
                            @if CURVES[number].2 == 1 {
                                polyline points=(frame.line(points.iter().map(|point| point.at))) {}
                            }
                            @for point in points { (frame.dot(number, point, None)) }
                        }
                    }
                }
            }
            figcaption { b { (grating.name) } ": " (relief(grating)) "." }
        }
    }
}
