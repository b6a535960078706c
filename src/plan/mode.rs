//! What a variant can compute: the modes, and which keys each of them reads.

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
    /// The sum over the orders of a cell that has few of them, also under lights with a size.
    Orders,
}

pub(super) const MODES: Words<Mode> = &[
    ("full", Mode::Full),
    ("pq", Mode::Pq),
    ("adaptive", Mode::Adaptive),
    ("gems", Mode::Gems),
    ("baked", Mode::Baked),
    ("orders", Mode::Orders),
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

/// A condition on a variant, under which its mode reads a key.
#[derive(Clone, Copy)]
pub(super) enum When {
    /// The number of terms is left to the tool.
    ChoosesTerms,
    /// The amplitude comes from a table that has the window in it.
    IsPrefiltered,
    /// The amplitude is a sum over bins.
    SumsBins,
    /// The range of wavelengths is wider than one.
    HasRange,
    /// The number of replicas is left to the tool.
    CountsReplicas,
    /// Errors above the limit are accepted.
    AcceptsError,
    /// It has a function for surroundings.
    HasSurroundings,
    /// Its functions have an argument for a pattern.
    HasPattern,
    /// It has functions for path tracers.
    HasPaths,
    /// The number of wavelengths under surroundings is left to the tool.
    ChoosesNodes,
    /// It has tables with wider lobes.
    HasSpread,
    /// It has tables with wider lobes and a function for surroundings.
    HasCells,
    /// The relief is a dielectric.
    IsDielectric,
    /// It is not a dielectric in air with Stam's obliquity.
    HasMatter,
}

/// The entries of the canonical configuration that a mode reads, apart from the mode itself. It ignores all others.
pub(super) struct Declared {
    /// Entries that every variant of the mode reads.
    pub(super) always: &'static [&'static [&'static str]],
    /// Entries that a variant reads if the condition holds.
    pub(super) sometimes: &'static [&'static [(&'static str, When)]],
    /// Entries that are not read, but rejected with a reason if they differ from the default, by [`super::constraints::broken`].
    pub(super) refused: &'static [&'static str],
}

/// The entries of a series of terms.
const SERIES: &[&str] = &["basis", "terms", "min_nm", "max_nm", "table", "packing"];
/// The entries of the coherence window.
const WINDOW: &[&str] = &["coherence_um", "coherence", "coherence_scaling"];
/// The entries of the gain and of the colours.
const COLOURS: &[&str] = &["shadowing", "illuminant", "colour"];
/// Further entries of the gain.
const MATTER: &[(&str, When)] = &[
    ("refractive_index", When::IsDielectric),
    ("material", When::HasMatter),
    ("cover_index", When::HasMatter),
    ("films", When::HasMatter),
    ("obliquity", When::HasMatter),
];

/// The entries of a pattern.
const PATTERN: &[(&str, When)] = &[
    ("pattern", When::HasPattern),
    ("period_ratio", When::HasPattern),
    ("depth_ratio", When::HasPattern),
];

const FULL: Declared = Declared {
    always: &[SERIES, WINDOW, COLOURS],
    sometimes: &[
        MATTER,
        &[
            ("term_error", When::ChoosesTerms),
            ("accept_error", When::AcceptsError),
            ("reconstruction", When::IsPrefiltered),
            ("window_radius", When::SumsBins),
            ("step_nm", When::HasRange),
            ("sampling", When::IsPrefiltered),
            ("hoist", When::SumsBins),
        ],
    ],
    refused: &["hoist"],
};

const PQ: Declared = Declared {
    always: &[SERIES, &["window_radius", "periods"], COLOURS],
    sometimes: &[
        MATTER,
        &[
            ("term_error", When::ChoosesTerms),
            ("accept_error", When::AcceptsError),
            ("step_nm", When::HasRange),
            ("coherence_um", When::CountsReplicas),
        ],
    ],
    refused: &["reconstruction", "hoist", "coherence", "coherence_scaling"],
};

const ADAPTIVE: Declared = Declared {
    always: &[SERIES, WINDOW, COLOURS],
    sometimes: &[
        MATTER,
        &[
            ("term_error", When::ChoosesTerms),
            ("accept_error", When::AcceptsError),
            ("reconstruction", When::IsPrefiltered),
            ("sampling", When::IsPrefiltered),
        ],
    ],
    refused: &["hoist"],
};

const BAKED: Declared = Declared {
    always: &[
        &["min_nm", "max_nm", "table", "sampling", "bake_error", "bake_mib"],
        WINDOW,
        COLOURS,
    ],
    sometimes: &[
        MATTER,
        &[
            ("spread_levels", When::HasSpread),
            ("spread_step", When::HasSpread),
            ("cells", When::HasCells),
            ("lights", When::HasSpread),
            ("lights", When::HasPaths),
        ],
    ],
    refused: &[],
};

const ORDERS: Declared = Declared {
    always: &[&["min_nm", "max_nm", "lights"], WINDOW, COLOURS],
    sometimes: &[
        MATTER,
        &[("nodes", When::HasSurroundings), ("environment_error", When::ChoosesNodes)],
        PATTERN,
    ],
    refused: &[],
};

const GEMS: Declared = Declared { always: &[], sometimes: &[], refused: &["colour"] };

impl Declared {
    /// Whether every variant of the mode reads an entry.
    pub(super) fn always_reads(&self, key: &str) -> bool {
        key == "mode" || self.always.iter().any(|group| group.contains(&key))
    }
}

pub(super) fn declared(mode: Mode) -> &'static Declared {
    match mode {
        Mode::Full => &FULL,
        Mode::Pq => &PQ,
        Mode::Adaptive => &ADAPTIVE,
        Mode::Baked => &BAKED,
        Mode::Gems => &GEMS,
        Mode::Orders => &ORDERS,
    }
}
