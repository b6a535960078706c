//! Results with the further numbers that the tables show.

use crate::results::{Bench, Scaling};

/// The result of a variant with the further numbers of its row.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct TimedVariant {
    pub(super) record: Bench,
    /// Texels that a lit pixel reads on average.
    pub(super) fetches: f64,
}

/// A point on an axis with the further numbers of its row.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Point {
    pub(super) record: Scaling,
    /// The amount of work. Time is expected to be proportional to it.
    pub(super) work: f64,
    /// Median processor time of a frame, all threads, ms.
    pub(super) cpu_ms: f64,
}
