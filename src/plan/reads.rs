//! Which keys each mode reads.

use super::{Auto, Mode, Reconstruction, Variant};

/// A condition on a variant.
type When = fn(&Variant) -> bool;

/// The entries of the canonical configuration that a mode reads, apart from the mode itself. It ignores all others.
pub(super) struct Declared {
    /// Entries that every variant of the mode reads.
    always: &'static [&'static str],
    /// Entries that a variant reads if the condition holds.
    sometimes: &'static [(&'static str, When)],
    /// Entries that are not read, but rejected with a reason if they differ from the default, by
    /// [`super::constraints::broken`].
    pub(super) refused: &'static [&'static str],
}

const FULL: Declared = Declared {
    always: &[
        "basis",
        "terms",
        "min_nm",
        "max_nm",
        "table",
        "packing",
        "coherence_um",
        "coherence",
        "coherence_scaling",
        "refractive_index",
        "shadowing",
        "illuminant",
        "colour",
    ],
    sometimes: &[
        ("term_error", chooses_terms),
        ("reconstruction", is_prefiltered),
        ("window_radius", sums_bins),
        ("step_nm", has_a_range),
        ("sampling", is_prefiltered),
        ("hoist", sums_bins),
    ],
    refused: &["hoist"],
};

const PQ: Declared = Declared {
    always: &[
        "basis",
        "terms",
        "window_radius",
        "periods",
        "min_nm",
        "max_nm",
        "table",
        "packing",
        "refractive_index",
        "shadowing",
        "illuminant",
        "colour",
    ],
    sometimes: &[
        ("term_error", chooses_terms),
        ("step_nm", has_a_range),
        ("coherence_um", counts_replicas),
    ],
    refused: &["reconstruction", "hoist", "coherence", "coherence_scaling"],
};

const ADAPTIVE: Declared = Declared {
    always: &[
        "basis",
        "terms",
        "min_nm",
        "max_nm",
        "table",
        "packing",
        "coherence_um",
        "coherence",
        "coherence_scaling",
        "refractive_index",
        "shadowing",
        "illuminant",
        "colour",
    ],
    sometimes: &[
        ("term_error", chooses_terms),
        ("reconstruction", is_prefiltered),
        ("sampling", is_prefiltered),
    ],
    refused: &["hoist"],
};

const BAKED: Declared = Declared {
    always: &[
        "min_nm",
        "max_nm",
        "table",
        "sampling",
        "bake_error",
        "bake_mib",
        "coherence_um",
        "coherence",
        "coherence_scaling",
        "refractive_index",
        "shadowing",
        "illuminant",
        "colour",
    ],
    sometimes: &[],
    refused: &[],
};

const GEMS: Declared = Declared { always: &[], sometimes: &[], refused: &["colour"] };

pub(super) fn declared(mode: Mode) -> &'static Declared {
    match mode {
        Mode::Full => &FULL,
        Mode::Pq => &PQ,
        Mode::Adaptive => &ADAPTIVE,
        Mode::Baked => &BAKED,
        Mode::Gems => &GEMS,
    }
}

fn chooses_terms(variant: &Variant) -> bool {
    variant.terms == Auto::Auto
}

pub(super) fn is_prefiltered(variant: &Variant) -> bool {
    variant.reconstruction == Reconstruction::Prefiltered
}

fn sums_bins(variant: &Variant) -> bool {
    !is_prefiltered(variant)
}

fn has_a_range(variant: &Variant) -> bool {
    variant.wavelengths.max_nm > variant.wavelengths.min_nm
}

fn counts_replicas(variant: &Variant) -> bool {
    variant.periods.is_none()
}

/// Whether a variant reads an entry of the canonical configuration.
pub(super) fn reads(variant: &Variant, key: &str) -> bool {
    let Declared { always, sometimes, .. } = declared(variant.mode);
    let is_such = |(known, is_such): &(&str, When)| *known == key && is_such(variant);
    key == "mode" || always.contains(&key) || sometimes.iter().any(is_such)
}

/// Whether variants of a mode may read an entry.
pub(super) fn declares(mode: Mode, key: &str) -> bool {
    let Declared { always, sometimes, .. } = declared(mode);
    key == "mode" || always.contains(&key) || sometimes.iter().any(|(known, _)| *known == key)
}
