//! Axes: a range that contains the data, ticks at round numbers.

use crate::report::number;

/// An axis.
pub(in crate::report) struct PlotAxis {
    /// Label with the unit.
    pub(in crate::report) label: String,
    /// Scale of the values.
    pub(in crate::report) scale: Scale,
}

/// Scale of an axis.
pub(in crate::report) enum Scale {
    /// Linear.
    Linear,
    /// Logarithmic. Values that are not positive are drawn at the edge.
    Log,
    /// Names, side by side. Values are their indices, from 0.
    Names(Vec<String>),
}

/// An axis fitted to its data.
pub(in crate::report) struct Fitted {
    log: bool,
    range: [f64; 2],
    span: [f64; 2],
    ticks: Vec<(f64, String)>,
}

impl Fitted {
    /// Position of a value in the plot.
    pub(in crate::report) fn place(&self, value: f64) -> f64 {
        let value = match self.log {
            true if value > 0.0 => value.log10(),
            true => f64::NEG_INFINITY,
            false => value,
        };
        let share = ((value - self.range[0]) / (self.range[1] - self.range[0])).clamp(0.0, 1.0);
        self.span[0] + share * (self.span[1] - self.span[0])
    }

    /// Positions and labels of the ticks.
    pub(in crate::report) fn ticks(&self) -> &[(f64, String)] {
        &self.ticks
    }
}

/// Fits an axis to values. `span` is the range of positions in the plot.
pub(in crate::report) fn fit(
    axis: &PlotAxis,
    values: impl Iterator<Item = f64>,
    span: [f64; 2],
) -> Fitted {
    let log = matches!(axis.scale, Scale::Log);
    let values: Vec<f64> = values
        .filter(|v| v.is_finite() && (!log || *v > 0.0))
        .map(|v| if log { v.log10() } else { v })
        .collect();
    let min = values.iter().copied().fold(f64::INFINITY, f64::min);
    let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let [min, max] = if values.is_empty() { [0.0, 1.0] } else { [min, max] };
    let (range, at) = match &axis.scale {
        Scale::Names(names) => {
            let at = names.iter().enumerate().map(|(i, name)| (i as f64, name.clone())).collect();
            ([-0.5, names.len() as f64 - 0.5], at)
        }
        Scale::Log => decades(min, max),
        Scale::Linear => round(min, max),
    };
    let mut fitted = Fitted { log: false, range, span, ticks: Vec::new() };
    fitted.ticks = at.into_iter().map(|(v, text): (f64, String)| (fitted.place(v), text)).collect();
    fitted.log = log;
    fitted
}

/// Range and ticks, in logarithms.
fn decades(min: f64, max: f64) -> ([f64; 2], Vec<(f64, String)>) {
    let margin = (0.06 * (max - min)).max(0.08);
    let range = [min - margin, max + margin];
    let (first, last) = (range[0].ceil() as i32, range[1].floor() as i32);
    let decades = f64::from(last - first);
    let stride = ((decades / 6.0).ceil() as usize).max(1);
    let mut ticks: Vec<(f64, String)> =
        (first..=last).step_by(stride).map(|e| (f64::from(e), number::power(e))).collect();
    if ticks.len() < 3 {
        let between = |e: i32, m: f64| (f64::from(e) + m.log10(), number::plain_power(m, e));
        let fine: &[f64] = if range[1] - range[0] < 0.7 {
            &[1.2, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]
        } else {
            &[2.0, 5.0]
        };
        let more = (first - 1..=last).flat_map(|e| fine.iter().map(move |m| between(e, *m)));
        ticks.extend(more.filter(|(at, _)| *at >= range[0] && *at <= range[1]));
    }
    (range, ticks)
}

/// Range and ticks at multiples of 1, 2 or 5 times a power of ten.
fn round(min: f64, max: f64) -> ([f64; 2], Vec<(f64, String)>) {
    let width = (max - min).max(1e-6 * max.abs()).max(1e-12);
    let range = [min - 0.06 * width, max + 0.06 * width];
    let rough = width / 4.0;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough);
    let step = step.unwrap_or(rough);
    let decimals = usize::try_from(-step.log10().floor() as i32).unwrap_or(0);
    let first = (range[0] / step).ceil() as i64;
    let last = (range[1] / step).floor() as i64;
    let ticks = (first..=last).map(|i| {
        let value = i as f64 * step;
        (value, format!("{value:.decimals$}"))
    });
    (range, ticks.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(scale: Scale, values: &[f64]) -> Vec<String> {
        let axis = PlotAxis { label: String::new(), scale };
        let fitted = fit(&axis, values.iter().copied(), [0.0, 100.0]);
        fitted.ticks().iter().map(|(_, text)| text.clone()).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(ticks(Scale::Linear, &[0.0, 20.0]), ["0", "5", "10", "15", "20"]);
        assert_eq!(ticks(Scale::Log, &[1e-3, 10.0]), ["10⁻³", "0.01", "0.1", "1", "10"]);
        assert_eq!(ticks(Scale::Log, &[1.0, 9.0]), ["1", "10", "2", "5"]);
    }

    #[test]
    fn what_is_not_positive_lies_at_the_edge_of_a_logarithm() {
        let axis = PlotAxis { label: String::new(), scale: Scale::Log };
        let fitted = fit(&axis, [0.0, 1.0, 100.0].into_iter(), [0.0, 100.0]);
        assert_eq!(fitted.place(0.0), 0.0);
        assert!((fitted.place(10.0) - 50.0).abs() < 1e-9);
        assert!(fitted.place(1.0) > 0.0 && fitted.place(100.0) < 100.0);
    }

    #[test]
    fn equal_and_absent_values_have_an_axis() {
        for values in [&[][..], &[3.0], &[0.0, 0.0]] {
            for scale in [Scale::Linear, Scale::Log] {
                let axis = PlotAxis { label: String::new(), scale };
                let fitted = fit(&axis, values.iter().copied(), [0.0, 100.0]);
                assert!(fitted.place(3.0).is_finite());
            }
        }
    }
}
