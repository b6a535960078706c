//! Warnings about reliefs whose size makes no sense.

use super::heights::Conversion;
use crate::surface::length::{name, shown};

/// Reliefs below this are flat to light: a mirror's roughness.
const LOW_UM: f64 = 1e-3;

/// Reliefs above this are no diffractive surface.
const HIGH_UM: f64 = 20.0;

/// The reliefs that a unit must give to be proposed: those that light diffracts at.
const SENSIBLE_UM: std::ops::RangeInclusive<f64> = 0.01..=10.0;

/// More than half of the steps being steeper than this (72°) means that heights and pixels have different units: optical
/// profilers and tips do not reach it, and upright walls are few.
const STEEP: f64 = 3.0;

/// Units that files use, µm.
const UNITS: [f64; 5] = [1e6, 1e3, 1.0, 1e-3, 1e-4];

/// A note about heights that are too low, too high or too steep for their pixels, with the unit that would make sense.
pub(super) fn note(
    heights_um: &[f64],
    columns: usize,
    pitch_um: (f64, f64),
    conversion: &Conversion,
    is_grey: bool,
) -> Option<String> {
    let (low, high) = heights_um
        .iter()
        .filter(|h| !h.is_nan())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
    let range = high - low;
    if !(range > 0.0 && range.is_finite()) {
        return None;
    }
    let what = if range < LOW_UM {
        format!("peak to valley {} nm, which is flat to light", shown(range * 1e3))
    } else if range > HIGH_UM {
        format!("peak to valley {} µm, which is far above a wavelength", shown(range))
    } else {
        let slope = median_slope(heights_um, columns, pitch_um);
        if slope <= STEEP {
            return None;
        }
        let degrees = slope.atan().to_degrees();
        format!("half of the surface is steeper than {degrees:.0}°, which no instrument measures")
    };
    let advice = if is_grey {
        "; check `height_um` and the pitch, which are in µm".to_owned()
    } else {
        units(range / conversion.unit_um().abs(), conversion)
    };
    Some(format!("warning: {what}{advice}"))
}

/// Which units would give a relief that makes sense. `range`: peak to valley in the file's numbers.
fn units(range: f64, conversion: &Conversion) -> String {
    let sensible: Vec<String> = UNITS
        .iter()
        .filter(|um| **um != conversion.unit_um() && SENSIBLE_UM.contains(&(range * **um)))
        .map(|um| {
            format!(
                "if the file's numbers are in {}, write z_unit_um = {um}",
                name(*um).unwrap_or("another unit")
            )
        })
        .collect();
    match (sensible.is_empty(), conversion.unit_is_assumed) {
        (true, true) => {
            "; the file names no unit, so its numbers are taken as µm: check `z_unit_um`".to_owned()
        }
        (true, false) => "; check the unit of the heights and the pitch".to_owned(),
        (false, true) => format!("; the file names no unit: {}", sensible.join("; ")),
        (false, false) => format!("; {}", sensible.join("; ")),
    }
}

/// The median slope along the steeper axis, from at most a million neighbours.
fn median_slope(heights: &[f64], columns: usize, (pitch_x, pitch_y): (f64, f64)) -> f64 {
    let stride = heights.len().div_ceil(1 << 20);
    let median = |step: usize, pitch: f64, inside: &dyn Fn(usize) -> bool| {
        let mut slopes: Vec<f64> = (0..heights.len().saturating_sub(step))
            .step_by(stride)
            .filter(|&i| inside(i))
            .map(|i| ((heights[i + step] - heights[i]) / pitch).abs())
            .filter(|slope| !slope.is_nan())
            .collect();
        if slopes.is_empty() {
            return 0.0;
        }
        let middle = slopes.len() / 2;
        *slopes.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let along_x = median(1, pitch_x, &|i| (i + 1) % columns != 0);
    along_x.max(median(columns, pitch_y, &|_| true))
}
