//! Which keys each mode reads.

use super::{Auto, Mode, Reconstruction, Variant};

/// A condition on a variant.
type When = fn(&Variant) -> bool;

/// What a mode does with the entries of the canonical configuration, the mode itself apart. All others it leaves alone.
pub(super) struct Declared {
    /// Read by every variant of the mode.
    always: &'static [&'static [&'static str]],
    /// Read where a variant is such.
    sometimes: &'static [(&'static str, When)],
    /// Not read, but refused with a reason where they differ from the default, by [`super::constraints::broken`].
    pub(super) refused: &'static [&'static str],
}

/// The entries of a series of terms.
const SERIES: &[&str] = &["basis", "terms", "min_nm", "max_nm", "table", "packing"];
/// The entries of the coherence window.
const WINDOW: &[&str] = &["coherence_um", "coherence", "coherence_scaling"];
/// The entries of the gain and of the colours.
const COLOURS: &[&str] = &["refractive_index", "shadowing", "illuminant", "colour"];

const FULL: Declared = Declared {
    always: &[SERIES, WINDOW, COLOURS],
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
    always: &[SERIES, &["window_radius", "periods"], COLOURS],
    sometimes: &[
        ("term_error", chooses_terms),
        ("step_nm", has_a_range),
        ("coherence_um", counts_replicas),
    ],
    refused: &["reconstruction", "hoist", "coherence", "coherence_scaling"],
};

const ADAPTIVE: Declared = Declared {
    always: &[SERIES, WINDOW, COLOURS],
    sometimes: &[
        ("term_error", chooses_terms),
        ("reconstruction", is_prefiltered),
        ("sampling", is_prefiltered),
    ],
    refused: &["hoist"],
};

const BAKED: Declared = Declared {
    always: &[
        &["min_nm", "max_nm", "table", "sampling", "bake_error", "bake_mib"],
        WINDOW,
        COLOURS,
    ],
    sometimes: &[],
    refused: &[],
};

const GEMS: Declared = Declared { always: &[], sometimes: &[], refused: &["colour"] };

impl Declared {
    fn always_reads(&self, key: &str) -> bool {
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
    let declared = declared(variant.mode);
    let is_such = |(known, is_such): &(&str, When)| *known == key && is_such(variant);
    declared.always_reads(key) || declared.sometimes.iter().any(is_such)
}

/// Whether variants of a mode may read an entry.
pub(super) fn declares(mode: Mode, key: &str) -> bool {
    let declared = declared(mode);
    declared.always_reads(key) || declared.sometimes.iter().any(|(known, _)| *known == key)
}
