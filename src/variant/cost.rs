//! Cost of a variant, counted without running it.

use glam::DVec3;
use serde::Serialize;

use crate::optics::brdf_map::view_directions;
use crate::tables::Series;

/// Cost of one lit pixel, independent of the driver. Forms with uniform wavelengths cost the same in every direction.
/// The cost of other forms depends on the direction; it is counted over the directions of `mean_and_worst`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Maximum number of evaluations of the amplitude: wavelength nodes, or lobes.
    pub evaluations: u64,
    /// Mean number of evaluations of the amplitude.
    pub evaluations_mean: f64,
    /// Maximum number of texels read from the term table.
    pub term_fetches: u64,
    /// Maximum number of texels read from all tables.
    pub fetches: u64,
    /// Mean number of texels read from all tables.
    pub fetches_mean: f64,
    /// Bytes of all tables.
    pub table_bytes: u64,
}

impl Cost {
    /// Cost of `evaluations`, as mean and maximum. Each reads `terms` texels of the term table and `others` texels of
    /// other tables.
    pub(super) fn of_evaluations(
        (mean, worst): (f64, u64),
        terms: u64,
        others: u64,
        table_bytes: u64,
    ) -> Cost {
        Cost {
            evaluations: worst,
            evaluations_mean: mean,
            term_fetches: worst * terms,
            fetches: worst * (terms + others),
            fetches_mean: mean * (terms + others) as f64,
            table_bytes,
        }
    }

    /// Cost of uniform wavelengths: `nodes` of them, each with a sum over `taps` bins.
    pub(super) fn uniform(series: &Series, nodes: usize, taps: u64) -> Cost {
        let nodes = nodes as u64;
        // two neighbouring texels of every row of coefficients for each tap, and the node
        let others = taps * 2 * u64::from(series.coefficient_rows()) + 1;
        let terms = taps * u64::from(series.layers());
        let table_bytes = series.byte_count() + spectrum_bytes(nodes, 2);
        Cost::of_evaluations((nodes as f64, nodes), terms, others, table_bytes)
    }

    /// Cost of `nodes` wavelengths, as mean and maximum. Each reads one interpolated value of a table.
    pub(super) fn between(
        series: &Series,
        wavelengths: (f64, u64),
        filters: bool,
        spectrum_bytes: u64,
    ) -> Cost {
        let texels = if filters { 1 } else { 4 };
        // the nearest column of coefficients, and the node
        let others = u64::from(series.coefficient_rows()) + 1;
        let terms = texels * u64::from(series.layers());
        Cost::of_evaluations(wavelengths, terms, others, series.byte_count() + spectrum_bytes)
    }
}

/// Bytes of a spectrum table, including its row of settings.
pub(super) fn spectrum_bytes(columns: u64, rows: u64) -> u64 {
    4 * 4 * columns * rows
}

/// Mean and maximum of a count over the disc of viewing directions.
pub(super) fn mean_and_worst_views(count: impl Fn(DVec3) -> u64) -> (f64, u64) {
    let (mut sum, mut worst) = (0, 0);
    let views = view_directions(SIDE as usize);
    for wr in &views {
        let found = count(*wr);
        sum += found;
        worst = worst.max(found);
    }
    (sum as f64 / views.len() as f64, worst)
}

/// Viewing directions along a side of the disc.
const SIDE: i32 = 48;

/// Cost of a direction's `(u, v)`, given by `count`: the mean over the disc of viewing directions, under a light 20°
/// from the normal in the plane of x, and the maximum over this disc and the mirror direction.
pub(super) fn mean_and_worst(count: impl Fn([f64; 2]) -> u64) -> (f64, u64) {
    /// sin 20°, rounded. It is a constant, so that counts are the same on every processor.
    const SIN_LIGHT: f64 = 0.342;
    let (mut sum, mut directions) = (0, 0);
    let mut worst = count([0.0, 0.0]);
    for row in 0..SIDE {
        for column in 0..SIDE {
            let place = |i: i32| f64::from(2 * i + 1 - SIDE) / f64::from(SIDE);
            let (x, y) = (place(column), place(row));
            if x * x + y * y < 1.0 {
                let found = count([-SIN_LIGHT - x, -y]);
                sum += found;
                directions += 1;
                worst = worst.max(found);
            }
        }
    }
    (sum as f64 / f64::from(directions), worst)
}
