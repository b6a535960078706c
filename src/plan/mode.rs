//! Modes: the methods by which a variant can compute colours.

use serde::{Deserialize, Serialize};

use super::words::{Words, word_of};

/// The method by which a variant computes colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Sum over bins under the window, at uniform wavelengths.
    Full,
    /// A finite number of replicas of the patch, without a window, at uniform wavelengths.
    Pq,
    /// Sum over the bins near the segment that the wavelengths trace in the frequency plane.
    Adaptive,
    /// The order sum of GPU Gems (2004), chapter 8: a comparator without a stated error.
    Gems,
    /// Colours from a table over `(u, v, w)`. The integral over wavelengths is in the table.
    Baked,
}

pub(super) const MODES: Words<Mode> = &[
    ("full", Mode::Full),
    ("pq", Mode::Pq),
    ("adaptive", Mode::Adaptive),
    ("gems", Mode::Gems),
    ("baked", Mode::Baked),
];

impl Mode {
    /// Every mode, in the order of the manual.
    pub fn all() -> impl Iterator<Item = Mode> {
        MODES.iter().map(|(_, mode)| *mode)
    }

    /// The mode's word in plans.
    pub fn as_str(self) -> &'static str {
        word_of(MODES, self)
    }
}
