//! Draws the response over wavelength and viewing angle, with the periods beside it.

use diffraction_shaders::encode::viridis;
use diffraction_shaders::error::{Error, Result};
use plotters::chart::MeshStyle;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::{Measurement, Protocol};

/// Text of the picture, and a measurement to compare with.
#[derive(Clone, Copy, Debug)]
pub struct HeatmapText<'a> {
    /// The title.
    pub title: &'a str,
    /// The same measurement on the closed form.
    pub yardstick: Option<&'a Measurement>,
}

const SIZE: (u32, u32) = (1200, 560);
/// Size of the map with its axes, in pixels. The rest is for the periods and the colour scale.
const SPLIT: [u32; 2] = [770, 1090];
/// Number of cells of the map over all angles: 0.2° each.
const CELLS: usize = 900;
/// Responses below this are drawn as zero, in dB relative to the largest.
const FLOOR_DB: f64 = -40.0;
/// Number of steps of the colour scale.
const LEVELS: usize = 20;
/// Colour of axes and text. The style below replaces it in dark themes.
const INK: RGBColor = RGBColor(0x1f, 0x23, 0x28);
const THEME: &str = "<style>@media (prefers-color-scheme: dark){[fill=\"#1F2328\"]{fill:#E6EDF3}[stroke=\"#1F2328\"]{stroke:#E6EDF3}}</style>";
const PEAK: RGBColor = RGBColor(0xe8, 0x59, 0x0c);
const CLOSED: RGBColor = RGBColor(0x2f, 0x81, 0xf7);
const GRATING: RGBColor = RGBColor(0xff, 0xff, 0xff);

/// Draws an SVG. The measurement must have the whole half circle of angles.
pub fn heatmap(
    measurement: &Measurement,
    protocol: &Protocol,
    picture: HeatmapText<'_>,
) -> Result<String> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        draw(&root, measurement, protocol, picture)
            .and_then(|()| root.present().map_err(|e| e.to_string()))
            .map_err(|e| Error::new(picture.title, e))?;
    }
    let end = text.find('>').map_or(0, |at| at + 1);
    text.insert_str(end, THEME);
    Ok(text)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), String>;

fn draw(root: &Area<'_>, m: &Measurement, protocol: &Protocol, picture: HeatmapText<'_>) -> Drawn {
    let root = root
        .titled(picture.title, ("sans-serif", 17).into_font().color(&INK))
        .map_err(|e| e.to_string())?;
    let (map, rest) = root.split_horizontally(SPLIT[0]);
    let (periods, scale) = rest.split_horizontally(SPLIT[1] - SPLIT[0]);
    draw_map(&map, m, protocol)?;
    draw_periods(&periods, m, protocol, picture.yardstick)?;
    draw_scale(&scale, picture.yardstick.is_some())
}

/// Lower and upper end of a wavelength's row, nm.
fn bands(m: &Measurement) -> Vec<(f64, f64)> {
    let nm: Vec<f64> = m.rows.iter().map(|row| row.lambda_nm).collect();
    let last = nm.len().saturating_sub(1);
    let half = |i: usize| 0.5 * (nm[i + 1] - nm[i]);
    let (first_half, last_half) = if last == 0 { (2.5, 2.5) } else { (half(0), half(last - 1)) };
    let low = |i: usize| nm[i] - if i == 0 { first_half } else { half(i - 1) };
    let high = |i: usize| nm[i] + if i == last { last_half } else { half(i) };
    (0..nm.len()).map(|i| (low(i), high(i))).collect()
}

fn span(m: &Measurement) -> (f64, f64) {
    let bands = bands(m);
    let (first, last) = (bands.first(), bands.last());
    (first.map_or(0.0, |b| b.0), last.map_or(1.0, |b| b.1))
}

fn draw_map(area: &Area<'_>, m: &Measurement, protocol: &Protocol) -> Drawn {
    let (low, high) = span(m);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(58)
        .build_cartesian_2d(-90.0..90.0, low..high)
        .map_err(|e| e.to_string())?;
    let cell_deg = 180.0 / CELLS as f64;
    let largest = m.rows.iter().flat_map(|r| &r.samples).map(|s| s.1).fold(0.0, f64::max);
    let ground = Rectangle::new([(-90.0, low), (90.0, high)], colour(0).filled());
    let mut cells = vec![ground];
    for (row, (from, to)) in m.rows.iter().zip(bands(m)) {
        let levels = levels(&row.samples, largest);
        let mut start = 0;
        // one rectangle for neighbours of one colour; the darkest colour is the background
        while start < CELLS {
            let run = levels[start..].iter().take_while(|l| **l == levels[start]).count();
            if levels[start] > 0 {
                let x = |i: usize| -90.0 + i as f64 * cell_deg;
                let corners = [(x(start), from), (x(start + run), to)];
                cells.push(Rectangle::new(corners, colour(levels[start]).filled()));
            }
            start += run;
        }
    }
    chart.draw_series(cells).map_err(|e| e.to_string())?;
    for m_order in [-3, -2, -1, 1, 2, 3] {
        let place = |lambda: &f64| {
            protocol.order(m_order, *lambda).map(|sin| (sin.asin().to_degrees(), *lambda))
        };
        let nm: Vec<f64> = (0..=100).map(|i| low + 0.01 * f64::from(i) * (high - low)).collect();
        let points: Vec<(f64, f64)> = nm.iter().filter_map(place).collect();
        let strength = if m_order.abs() == 1 { 0.9 } else { 0.35 };
        let line = DashedLineSeries::new(points, 5, 5, GRATING.mix(strength).stroke_width(1));
        chart.draw_series(line).map_err(|e| e.to_string())?;
    }
    let circles = m.rows.iter().filter_map(|row| {
        row.peak.map(|p| Circle::new((p.theta_deg, row.lambda_nm), 2, PEAK.stroke_width(1)))
    });
    chart.draw_series(circles).map_err(|e| e.to_string())?;
    styled(&mut chart.configure_mesh())
        .x_labels(13)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.0}"))
        .x_desc("viewing angle θr, degrees (positive: mirror side)")
        .y_desc("wavelength, nm")
        .draw()
        .map_err(|e| e.to_string())
}

type Mesh<'c, 'm, 's> = MeshStyle<'c, 'm, RangedCoordf64, RangedCoordf64, SVGBackend<'s>>;

/// Axes without a grid.
fn styled<'a, 'c, 'm, 's>(mesh: &'a mut Mesh<'c, 'm, 's>) -> &'a mut Mesh<'c, 'm, 's> {
    mesh.disable_mesh()
        .axis_style(INK)
        .label_style(("sans-serif", 13).into_font().color(&INK))
        .axis_desc_style(("sans-serif", 14).into_font().color(&INK))
}

/// Level of every cell: of its largest sample, or of the sample before it where it has none.
fn levels(samples: &[(f64, f64)], largest: f64) -> Vec<usize> {
    let mut cells = vec![f64::NAN; CELLS];
    for (theta_deg, response) in samples {
        let cell = ((theta_deg + 90.0) / 180.0 * CELLS as f64) as usize;
        let cell = &mut cells[cell.min(CELLS - 1)];
        *cell = cell.max(*response);
    }
    let mut before = 0.0;
    for cell in &mut cells {
        before = if cell.is_nan() { before } else { *cell };
        *cell = before;
    }
    let level = |response: &f64| {
        let share = 1.0 - 10.0 * (response / largest).log10() / FLOOR_DB;
        if share > 0.0 { (share * LEVELS as f64).round() as usize } else { 0 }
    };
    cells.iter().map(level).collect()
}

fn colour(level: usize) -> RGBColor {
    let [r, g, b] = viridis(level as f64 / LEVELS as f64);
    RGBColor(r, g, b)
}

fn draw_periods(
    area: &Area<'_>,
    m: &Measurement,
    protocol: &Protocol,
    yardstick: Option<&Measurement>,
) -> Drawn {
    let points = |m: &Measurement| -> Vec<(f64, f64)> {
        let point = |row: &super::WavelengthRow| row.peak.map(|p| (p.period_nm, row.lambda_nm));
        m.rows.iter().filter_map(point).collect()
    };
    let (found, closed) = (points(m), yardstick.map(points).unwrap_or_default());
    // for a grating this is its true period; for a scan only the start of the search
    let known = yardstick.map(|_| 1e3 * protocol.expected_um);
    let all = found.iter().chain(&closed).map(|p| p.0).chain(known);
    let (least, most) =
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let (least, most) = if least <= most { (least, most) } else { (0.0, 1.0) };
    let pad = (0.1 * (most - least)).max(1e-5 * most);
    let (low, high) = span(m);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .margin_right(22)
        .x_label_area_size(42)
        .y_label_area_size(16)
        .build_cartesian_2d(least - pad..most + pad, low..high)
        .map_err(|e| e.to_string())?;
    let digits = (2.0 - (most - least + pad).log10().floor()).clamp(0.0, 4.0) as usize;
    styled(&mut chart.configure_mesh())
        .x_labels(4)
        .y_labels(0)
        .x_label_formatter(&|x| format!("{x:.digits$}"))
        .x_desc("period λ/|sin θr − sin θi|, nm")
        .draw()
        .map_err(|e| e.to_string())?;
    if let Some(known) = known {
        let line = DashedLineSeries::new([(known, low), (known, high)], 5, 5, INK.stroke_width(1));
        chart.draw_series(line).map_err(|e| e.to_string())?;
    }
    chart
        .draw_series(LineSeries::new(closed, CLOSED.stroke_width(2)))
        .map_err(|e| e.to_string())?;
    let circles = found.into_iter().map(|p| Circle::new(p, 2, PEAK.filled()));
    chart.draw_series(circles).map_err(|e| e.to_string())?;
    Ok(())
}

fn draw_scale(area: &Area<'_>, has_closed_form: bool) -> Drawn {
    let style = |size: u32| ("sans-serif", size).into_font().color(&INK);
    let text = |words: &str, size: u32, x: i32, y: i32| {
        area.draw_text(words, &style(size), (x, y)).map_err(|e| e.to_string())
    };
    let (top, height) = (40, 190);
    text("|P|², dB", 13, 0, top - 24)?;
    for level in 0..=LEVELS {
        let y = |i: usize| top + height - (i as i32 * height) / (LEVELS as i32 + 1);
        let corners = [(0, y(level + 1)), (18, y(level))];
        area.draw(&Rectangle::new(corners, colour(level).filled())).map_err(|e| e.to_string())?;
    }
    text("0", 13, 26, top)?;
    text(&format!("{:.0}", 0.5 * FLOOR_DB), 13, 26, top + height / 2 - 7)?;
    text(&format!("≤ {FLOOR_DB:.0}"), 13, 26, top + height - 13)?;
    let legend = top + height + 34;
    let dot = Circle::new((6, legend + 7), 3, PEAK.filled());
    area.draw(&dot).map_err(|e| e.to_string())?;
    text("peak", 13, 20, legend)?;
    let line = |y: i32, colour: RGBColor| {
        let path = PathElement::new([(0, y), (14, y)], colour.stroke_width(2));
        area.draw(&path).map_err(|e| e.to_string())
    };
    if has_closed_form {
        line(legend + 79, CLOSED)?;
        text("closed form", 13, 20, legend + 72)?;
    }
    for x in [0, 8] {
        let path = PathElement::new(
            [(x, legend + 31), (x + 5, legend + 31)],
            RGBColor(0x80, 0x88, 0x90).stroke_width(2),
        );
        area.draw(&path).map_err(|e| e.to_string())?;
    }
    text("grating", 13, 20, legend + 24)?;
    text("equation", 13, 20, legend + 40)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_take_their_largest_sample_and_fill_gaps() {
        let found = levels(&[(-89.95, 1e-9), (-89.9, 1.0), (-0.01, 0.1), (0.5, 1e-5)], 1.0);
        assert_eq!((found[0], found[1], found[CELLS / 2 - 1]), (LEVELS, LEVELS, 15));
        assert_eq!((found[CELLS / 2 + 1], found[CELLS - 1]), (15, 0));
    }
}
