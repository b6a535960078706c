//! Progress of a long run.

use crate::error::Error;

/// Progress that [`super::Compiler::compile`] reports.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// A surface and variant that is finished.
    Finished(&'a str),
    /// Finished columns of a table of colours. Reported from any thread.
    Baked {
        /// Surface and variant.
        label: &'a str,
        /// Columns finished since the last call.
        columns: usize,
        /// Number of all columns.
        of: usize,
    },
    /// The cache could not take something, and why. The package is complete all the same. Reported once, at the end.
    NotCached(&'a Error),
}
