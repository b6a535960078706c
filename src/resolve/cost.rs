//! What a variant costs, counted before anything runs.

use serde::Serialize;

use crate::plan::{Mode, Variant};

use super::{Corridor, Lobes, Resolved, node_level};

/// What one lit pixel costs, whatever the driver. The modes with uniform wavelengths cost the same everywhere;
/// `adaptive` costs what its direction meets, counted over `mean_and_worst`'s directions.
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

/// Counts a variant's work.
pub(super) fn cost(variant: &Variant, resolved: &Resolved, lobes: &Lobes) -> Cost {
    if variant.mode == Mode::Baked {
        // two neighbouring levels, filtered or not
        let fetches: u64 = if variant.filters() { 2 } else { 8 };
        let texel = crate::tables::colour_format(variant.table).texel_bytes() as u64;
        return Cost {
            fetches,
            fetches_mean: fetches as f64,
            table_bytes: resolved.axes.texels() * texel,
            ..Cost::default()
        };
    }
    let layers = u64::from(resolved.layers);
    let most_nodes = resolved.node_counts.iter().copied().max().map(u64::from);
    let nodes = match variant.mode {
        Mode::Gems | Mode::Baked => 1,
        Mode::Adaptive if most_nodes.is_some() => most_nodes.unwrap_or(1),
        _ => variant.wavelengths.nodes_nm().len() as u64,
    };
    let shape = crate::tables::terms_shape(
        resolved.bins,
        resolved.expansion.terms as usize,
        variant.packing,
        variant.table,
    );
    let spectrum_bytes = match variant.mode {
        Mode::Adaptive if most_nodes.is_none() => {
            let Corridor { columns, rows, .. } = resolved.corridor;
            4 * 4 * u64::from(columns) * u64::from(2 * rows + 2)
        }
        // the settings are a row of their own
        _ => 4 * 4 * nodes * (resolved.node_counts.len().max(1) as u64 + 1),
    };
    let rows = crate::tables::coefficient_rows(&resolved.expansion) as u64;
    let coefficient_bytes = rows * resolved.coefficient_count as u64 * 4 * 4;
    let table_bytes = shape.byte_count() as u64 + spectrum_bytes + coefficient_bytes;
    // neighbouring texels of every row of coefficients
    let coefficients = 2 * rows;
    let uniform = |taps: u64| Cost {
        evaluations: nodes,
        evaluations_mean: nodes as f64,
        term_fetches: nodes * taps * layers,
        fetches: nodes * (taps * (layers + coefficients) + 1),
        fetches_mean: (nodes * (taps * (layers + coefficients) + 1)) as f64,
        table_bytes,
    };
    if resolved.grid.is_some() {
        let texels = if variant.filters() { 1 } else { 4 };
        let (mean, worst) = match most_nodes {
            None => (nodes as f64, nodes),
            Some(worst) => {
                let count = |uv: [f64; 2]| {
                    u64::from(resolved.node_counts[node_level(uv[0].hypot(uv[1])) as usize])
                };
                (mean_and_worst(count).0, worst)
            }
        };
        // neighbouring texels of every layer, the nearest coefficients, the node
        let fetches = texels * layers + rows + 1;
        return Cost {
            evaluations: worst,
            evaluations_mean: mean,
            term_fetches: worst * texels * layers,
            fetches: worst * fetches,
            fetches_mean: mean * fetches as f64,
            table_bytes,
        };
    }
    match variant.mode {
        Mode::Full => uniform(u64::from(2 * resolved.window_radius + 1).pow(2)),
        Mode::Pq => uniform(u64::from(resolved.taps[0]) * u64::from(resolved.taps[1])),
        Mode::Gems | Mode::Baked => {
            Cost { fetches: 1, fetches_mean: 1.0, table_bytes: spectrum_bytes, ..Cost::default() }
        }
        Mode::Adaptive => {
            let (mean, worst) =
                mean_and_worst(|uv| lobe_evaluations(lobes, &resolved.corridor, uv));
            // two neighbouring texels of colour weights
            let fetches = layers + coefficients + 2;
            Cost {
                evaluations: worst,
                evaluations_mean: mean,
                term_fetches: worst * layers,
                fetches: worst * fetches,
                fetches_mean: mean * fetches as f64,
                table_bytes,
            }
        }
    }
}

/// Evaluations of the bins, mean over the disc of viewing directions under a light 20° from the normal in the plane of x,
/// and the most over that disc and its mirror direction.
fn mean_and_worst(count: impl Fn([f64; 2]) -> u64) -> (f64, u64) {
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

/// Evaluations of the bins that the wavelengths of a direction meet.
fn lobe_evaluations(lobes: &Lobes, corridor: &Corridor, uv: [f64; 2]) -> u64 {
    let breadth = lobes.breadth(uv, corridor.nodes);
    if breadth < 1.0 {
        let row = (breadth * (f64::from(corridor.rows) - 1.0) + 0.5) as u32;
        let sides = if Lobes::is_halved(row, corridor.rows) { 2 } else { 1 };
        return sides * lobes.bins(uv).len() as u64;
    }
    (0..corridor.nodes).map(|node| lobes.node_bins(uv, node, corridor.nodes)).sum()
}
