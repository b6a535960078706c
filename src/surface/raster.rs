//! The result of the readers of height files.

/// The result of a format's reader: numbers in the file's own units.
pub(super) struct Raster {
    pub columns: usize,
    pub rows: usize,
    pub samples: Samples,
    /// Pixel pitch along x and y in µm, if the file has one.
    pub scale: Option<(f64, f64)>,
    pub notes: Vec<String>,
}

/// Samples `[row][column]`, top row first, NaN where void.
pub(super) enum Samples {
    /// Shares of the full grey range, 0 to 1.
    Grey { shares: Vec<f64>, bits: u8 },
    /// Numbers. `unit_um`: µm per unit, if the file states it. `needs_unit`: the file states a unit that is not a length.
    Float { values: Vec<f64>, unit_um: Option<f64>, needs_unit: bool },
}

impl Samples {
    pub(super) fn float(values: Vec<f64>) -> Samples {
        Samples::Float { values, unit_um: None, needs_unit: false }
    }
}
