//! Tables of probabilities from which path tracers draw directions.

mod colours;
mod orders;

pub use colours::{PATH_LEVELS, colour_paths_shape, colour_paths_table, path_columns};
pub use orders::{OrderPaths, order_paths_shape, order_paths_table, wavelength_cells};

/// Part of the probability that is the same everywhere: what an estimate from one angle and one wavelength leaves out must
/// still be drawn, or the mean of the paths is too dim.
pub const FLOOR: f64 = 0.1;
