//! Finds the cheapest variant of a surface within an error budget.
//!
//! 1. [`candidates`]: the plan's own variants, and presets, as text, from a grid over all that this version can build. Light and
//!    material are those of the plan's `[optics]`, which define the right colours.
//! 2. [`prune`]: removes candidates by bounds, sizes and counts, before anything is computed.
//! 3. [`search`]: decides whose colours are computed, in which order. [`colours`] compares them with the exact colours.
//! 4. Times, drawn in turns with the baseline: see [`bench`](crate::bench).
//! 5. [`verdict`]: the front of time and error, and the winner.
//!
//! Everything except the times is the same in every run: candidates, order, directions, errors.

pub mod candidates;
pub mod colours;
pub mod prune;
pub mod search;
pub mod verdict;

mod grid;
mod preset;

use diffraction_shaders::plan::Variant;
use diffraction_shaders::variant::{Cost, Form};

use crate::results::{Bounds, Verdict};

pub use preset::preset;

/// A variant that can be built on the surface.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The variant.
    pub variant: Variant,
    /// How it computes on the surface.
    pub on: Form,
    /// The text of its preset.
    pub preset: String,
    /// Its configuration without numbers. Among candidates of one kind, counts decide which is faster.
    pub kind: String,
    /// A-priori bounds of its error.
    pub bounds: Bounds,
    /// Cost of a lit pixel.
    pub cost: Cost,
}

impl Candidate {
    /// Texels that a lit pixel reads on average.
    pub fn fetches(&self) -> f64 {
        self.cost.fetches_mean
    }

    /// Size of all tables in bytes.
    pub fn table_bytes(&self) -> u64 {
        self.cost.table_bytes
    }
}

/// A candidate that does not take part, with the reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Lost {
    /// Its name.
    pub name: String,
    /// The text of its preset.
    pub preset: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The reason in words.
    pub why: String,
}
