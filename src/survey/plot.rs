//! A plot: an area with axes, and a colour bar.

use crate::encode::viridis;

use super::canvas::{ADVANCE, Align, Canvas, Colour, INK, LINE};

/// Space around the area for ticks, labels and the title.
const LEFT: i64 = 6 * ADVANCE + 8;
const TOP: i64 = 4 * LINE;
const BOTTOM: i64 = 4 * LINE;
const BAR: i64 = 20;
const GAP: i64 = 24;
const TICK: i64 = 6;

/// One axis, linear.
#[derive(Clone, Debug)]
pub(super) struct PlotRange {
    pub(super) low: f64,
    pub(super) high: f64,
    /// What it measures, with its unit.
    pub(super) name: String,
}

impl PlotRange {
    /// Positions and labels of ticks at round numbers. Positions are shares of the length, from the low end.
    fn ticks(&self) -> Vec<(f64, String)> {
        let extent = self.high - self.low;
        if extent <= 0.0 || !extent.is_finite() {
            return vec![(0.5, format!("{:.0}", self.low))];
        }
        let rough = extent / 8.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|n| n * power).into_iter().find(|s| *s >= rough);
        let step = step.unwrap_or(10.0 * power);
        let digits = (-(step * 1.0001).log10().floor()).max(0.0) as usize;
        let (first, last) = (self.low / step - 1e-9, self.high / step + 1e-9);
        (first.ceil() as i64..=last.floor() as i64)
            .map(|n| {
                let value = n as f64 * step;
                ((value - self.low) / extent, format!("{value:.digits$}"))
            })
            .collect()
    }
}

/// A canvas with an area to draw in.
pub(super) struct Plot {
    pub(super) canvas: Canvas,
    /// Left and top of the area.
    pub(super) left: i64,
    pub(super) top: i64,
    /// Size of the area.
    pub(super) width: i64,
    pub(super) height: i64,
}

impl Plot {
    /// An empty area with frame, axes and title; `bar` adds a colour bar at its right.
    pub(super) fn new(
        title: &str,
        [width, height]: [i64; 2],
        x: &PlotRange,
        y: &PlotRange,
        bar: Option<&PlotRange>,
    ) -> Plot {
        let right = if bar.is_some() { GAP + BAR + 7 * ADVANCE } else { 2 * ADVANCE };
        let whole = (LEFT + width + right).max((title.chars().count() as i64 + 2) * ADVANCE);
        let canvas = Canvas::new(whole, TOP + height + BOTTOM);
        let mut plot = Plot { canvas, left: LEFT, top: TOP, width, height };
        plot.canvas.label(title, ADVANCE, LINE / 2, Align::Left);
        plot.canvas.frame(LEFT, TOP, width, height);
        plot.axes(x, y);
        if let Some(bar) = bar {
            plot.bar(bar);
        }
        plot
    }

    /// A curve of one value of `y` for each column of the area, with its colour and its width in pixels. `dash`: length of
    /// a dash and of a gap, pixels.
    pub(super) fn curve(
        &mut self,
        values: &[f64],
        y: &PlotRange,
        (colour, width): (Colour, i64),
        dash: Option<i64>,
    ) {
        let Plot { left, top, height, .. } = *self;
        let extent = (y.high - y.low).max(f64::MIN_POSITIVE);
        let row = |value: f64| ((y.high - value) / extent * (height - 1) as f64).round() as i64;
        for (column, pair) in (0..).zip(values.windows(2)) {
            if dash.is_some_and(|dash| column / dash % 2 == 1) {
                continue;
            }
            let begin = (row(pair[0].max(pair[1])) - width / 2).max(0);
            let end = (row(pair[0].min(pair[1])) + width / 2).min(height - 1);
            self.canvas.fill(left + column, top + begin, 2, end - begin + 1, colour);
        }
    }

    fn axes(&mut self, x: &PlotRange, y: &PlotRange) {
        let Plot { left, top, width, height, .. } = *self;
        let bottom = top + height;
        for (share, text) in x.ticks() {
            let at = left + (share * (width - 1) as f64).round() as i64;
            self.canvas.fill(at, bottom, 1, TICK, INK);
            self.canvas.label(&text, at, bottom + TICK + 4, Align::Centre);
        }
        self.canvas.label(&x.name, left + width / 2, bottom + TICK + 10 + LINE, Align::Centre);
        for (share, text) in y.ticks() {
            let at = bottom - 1 - (share * (height - 1) as f64).round() as i64;
            self.canvas.fill(left - TICK, at, TICK, 1, INK);
            self.canvas.label(&text, left - TICK - 4, at - LINE / 2, Align::Right);
        }
        self.canvas.label(&y.name, ADVANCE, top - LINE - 8, Align::Left);
    }

    fn bar(&mut self, scale: &PlotRange) {
        let Plot { left, top, width, height, .. } = *self;
        let at = left + width + GAP;
        for row in 0..height {
            let share = 1.0 - row as f64 / (height - 1).max(1) as f64;
            self.canvas.fill(at, top + row, BAR, 1, viridis(share));
        }
        self.canvas.frame(at, top, BAR, height);
        for (share, text) in scale.ticks() {
            let y = top + height - 1 - (share * (height - 1) as f64).round() as i64;
            self.canvas.fill(at + BAR, y, TICK, 1, INK);
            self.canvas.label(&text, at + BAR + TICK + 4, y - LINE / 2, Align::Left);
        }
        self.canvas.label(&scale.name, at, top - LINE - 8, Align::Left);
    }
}
