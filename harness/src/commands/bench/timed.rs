//! Results with what the tables say beside them.

use crate::results::{Bench, Scaling};

/// A result with what the table says beside it.
#[derive(Clone, Debug)]
pub(super) struct TimedVariant {
    pub(super) record: Bench,
    /// Texels that a lit pixel reads, on average.
    pub(super) fetches: f64,
}

/// A point of an axis with what the table says beside it.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub(super) record: Scaling,
    /// What the time is expected to be proportional to.
    pub(super) work: f64,
    /// Median time of the processor for a frame, all threads, ms.
    pub(super) cpu_ms: f64,
}
