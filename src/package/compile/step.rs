//! What a long run tells.

/// What a run of [`super::generate`] tells while it goes on.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// Surface and variant that are finished.
    Finished(&'a str),
    /// Columns of a table of colours that were finished since the last call, of so many; from any thread.
    Baked {
        /// Surface and variant.
        label: &'a str,
        /// Columns since the last call.
        columns: usize,
        /// All columns.
        of: usize,
    },
}
