//! What a variant costs, counted before anything runs.

use serde::Serialize;

use crate::tables::Series;

/// What one lit pixel costs, whatever the driver. Forms with uniform wavelengths cost the same everywhere; the others
/// cost what their direction meets, counted over the directions of `mean_and_worst`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Evaluations of the amplitude, at worst: wavelength nodes, or lobes.
    pub evaluations: u64,
    /// The same on average.
    pub evaluations_mean: f64,
    /// Texels read from the term table, at worst.
    pub term_fetches: u64,
    /// All texels read, at worst.
    pub fetches: u64,
    /// The same on average.
    pub fetches_mean: f64,
    /// Bytes of all tables.
    pub table_bytes: u64,
}

impl Cost {
    /// `evaluations`, mean and worst, each of which reads `terms` texels of the term table and `others`.
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

    /// Uniform wavelengths, `nodes` of them, each of which adds up `taps` bins.
    pub(super) fn uniform(series: &Series, nodes: usize, taps: u64) -> Cost {
        let nodes = nodes as u64;
        // neighbouring texels of every row of coefficients for each tap, and the node
        let others = taps * 2 * u64::from(series.coefficient_rows()) + 1;
        let terms = taps * u64::from(series.layers());
        let table_bytes = series.byte_count() + spectrum_bytes(nodes, 2);
        Cost::of_evaluations((nodes as f64, nodes), terms, others, table_bytes)
    }

    /// Wavelengths, mean and worst, each of which reads once between the texels of a table.
    pub(super) fn between(
        series: &Series,
        wavelengths: (f64, u64),
        filters: bool,
        spectrum_bytes: u64,
    ) -> Cost {
        let texels = if filters { 1 } else { 4 };
        // the nearest coefficients, and the node
        let others = u64::from(series.coefficient_rows()) + 1;
        let terms = texels * u64::from(series.layers());
        Cost::of_evaluations(wavelengths, terms, others, series.byte_count() + spectrum_bytes)
    }
}

/// Bytes of a spectrum table, its row of settings included.
pub(super) fn spectrum_bytes(columns: u64, rows: u64) -> u64 {
    4 * 4 * columns * rows
}

/// What a direction's `(u, v)` costs, mean over the disc of viewing directions under a light 20° from the normal in the plane
/// of x, and the most over that disc and its mirror direction.
pub(super) fn mean_and_worst(count: impl Fn([f64; 2]) -> u64) -> (f64, u64) {
    const SIDE: i32 = 48;
    /// sin 20°, rounded: configured, so that the counts are the same on every processor.
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
