//! What a variant can compute: the modes.

use serde::{Deserialize, Serialize};

use super::words::{Words, word_of};

/// What a variant computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Window over the bins, uniform wavelengths.
    Full,
    /// Replicas of the patch without a window, uniform wavelengths.
    Pq,
    /// Bins near the segment that the wavelengths walk in the frequency plane.
    Adaptive,
    /// The order sum of GPU Gems (2004), chapter 8: a comparator without a stated error.
    Gems,
    /// Colours from a table over `(u, v, w)`: the wavelengths are integrated beforehand.
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

    /// The word of the plan.
    pub fn as_str(self) -> &'static str {
        word_of(MODES, self)
    }
}
