//! The cheapest variant of a surface within an error budget.
//!
//! 1. [`candidates`]: presets of a plan, as text, from a grid over what a version may build, and the plan's own variants.
//!    Light and material stay those of the plan's `[optics]`: they say what is right.
//! 2. [`prune`]: what bounds, sizes and counts say before anything is computed.
//! 3. [`search`]: whose colours are computed, in which order; [`colours`] compares them with the exact ones.
//! 4. Times, drawn in turns with the baseline: see [`bench`](crate::bench).
//! 5. [`verdict`]: the front of time and error, and the winner.
//!
//! All but the times is the same in every run: candidates, order, directions, errors.

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

/// A variant that can be laid on the surface.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The variant.
    pub variant: Variant,
    /// How it computes on the surface.
    pub on: Form,
    /// The text of its preset.
    pub preset: String,
    /// What it is configured to, numbers apart. Of candidates of one kind the counts say which is faster.
    pub kind: String,
    /// What is known of its error.
    pub bounds: Bounds,
    /// What a lit pixel costs.
    pub cost: Cost,
}

impl Candidate {
    /// Texels that a lit pixel reads, on average.
    pub fn fetches(&self) -> f64 {
        self.cost.fetches_mean
    }

    /// Bytes of all tables.
    pub fn table_bytes(&self) -> u64 {
        self.cost.table_bytes
    }
}

/// A candidate that takes no part, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Lost {
    /// Its name.
    pub name: String,
    /// The text of its preset.
    pub preset: String,
    /// What became of it.
    pub verdict: Verdict,
    /// Why, in words.
    pub why: String,
}
