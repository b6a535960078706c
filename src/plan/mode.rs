//! What a variant can compute: the modes, which keys each of them reads, and the combinations that mean nothing.

use serde::{Deserialize, Serialize};

use super::axis::Entry;
use super::variant::axes;
use super::words::{Words, word_of};
use super::{
    Auto, Basis, Coherence, CoherenceScaling, Colour, Optics, Reconstruction, TableFormat, Variant,
};

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

/// What a mode does with the entries of the canonical configuration, the mode itself apart. All others it leaves alone.
struct Declared {
    /// Read by every variant of the mode.
    always: &'static [&'static str],
    /// Read where a variant is such.
    sometimes: &'static [(&'static str, fn(&Variant) -> bool)],
    /// Not read, but refused with a reason where they differ from the default, by [`broken`].
    refused: &'static [&'static str],
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

impl Mode {
    fn declared(self) -> &'static Declared {
        match self {
            Mode::Full => &FULL,
            Mode::Pq => &PQ,
            Mode::Adaptive => &ADAPTIVE,
            Mode::Baked => &BAKED,
            Mode::Gems => &GEMS,
        }
    }
}

fn chooses_terms(variant: &Variant) -> bool {
    variant.terms == Auto::Auto
}

fn is_prefiltered(variant: &Variant) -> bool {
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
    let Declared { always, sometimes, .. } = variant.mode.declared();
    let is_such =
        |(known, is_such): &(&str, fn(&Variant) -> bool)| *known == key && is_such(variant);
    key == "mode" || always.contains(&key) || sometimes.iter().any(is_such)
}

/// Whether variants of a mode may read an entry.
pub(super) fn declares(mode: Mode, key: &str) -> bool {
    let Declared { always, sometimes, .. } = mode.declared();
    key == "mode" || always.contains(&key) || sometimes.iter().any(|(known, _)| *known == key)
}

/// Sets every entry that a variant does not read to its documented default, except where [`broken`] has to see it.
pub(super) fn normalise(variant: &mut Variant) {
    let standard = Variant::standard(&Optics::standard());
    let refused = variant.mode.declared().refused;
    let entries = axes().flat_map(|axis| axis.entries);
    let is_idle = |key| !reads(variant, key) && !refused.contains(&key);
    let idle: Vec<&Entry> = entries.filter(|entry| is_idle(entry.key)).collect();
    idle.into_iter().for_each(|entry| (entry.copy)(&standard, variant));
}

/// The constraints that a configuration breaks: the key, and the reason.
pub(super) fn broken(variant: &Variant) -> Vec<(&'static str, String)> {
    let (mode, optics) = (variant.mode, &variant.optics);
    let ensemble = optics.coherence == Coherence::Ensemble;
    let mut found = Vec::new();
    let mut refuse = |when: bool, key: &'static str, reason: &str| {
        if when {
            found.push((key, reason.to_owned()));
        }
    };
    let prefiltered = is_prefiltered(variant);
    refuse(
        variant.filters() && variant.table == TableFormat::F32,
        "sampling",
        "WebGPU and WebGL2 filter no tables of 32-bit floats; use table = \"f16\"",
    );
    refuse(
        prefiltered && mode == Mode::Pq,
        "reconstruction",
        "pq has no coherence window that a table could have in it",
    );
    refuse(
        prefiltered && ensemble,
        "coherence",
        "a prefiltered table holds amplitudes under one window, and coherence = \"ensemble\" adds intensities of orders before the window",
    );
    refuse(
        prefiltered && optics.coherence_scaling == CoherenceScaling::Wavelength,
        "coherence_scaling",
        "a prefiltered table has one window in it, the same for all wavelengths",
    );
    refuse(
        prefiltered && !variant.hoist,
        "hoist",
        "hoist = false is the loop of the texts over bins, and a prefiltered table needs no such loop",
    );
    refuse(
        mode != Mode::Baked && variant.table == TableFormat::Rgb9e5,
        "table",
        "numbers with a shared exponent have no sign, and only the colours of mode = \"baked\" need none",
    );
    refuse(
        mode == Mode::Baked && variant.wavelengths.max_nm <= variant.wavelengths.min_nm,
        "wavelengths",
        "baked integrates over the wavelengths, and a single one leaves nothing to integrate",
    );
    let tabulated = matches!(variant.basis, Basis::Chebyshev | Basis::Optimal);
    refuse(
        tabulated && !variant.hoist && mode == Mode::Full && !prefiltered,
        "basis",
        "hoist = false is the loop of the texts over powers, and the coefficients of this basis are no powers",
    );
    match mode {
        Mode::Full => refuse(
            ensemble && !variant.hoist,
            "hoist",
            "hoist = false adds the bins of each term before anything is squared, and an ensemble adds intensities of bins",
        ),
        Mode::Pq => {
            refuse(
                ensemble,
                "coherence",
                "pq repeats the patch without a coherence window, so coherence = \"ensemble\" has no meaning",
            );
            refuse(
                optics.coherence_scaling == CoherenceScaling::Wavelength,
                "coherence_scaling",
                "pq repeats the patch a whole number of times, the same for all wavelengths",
            );
        }
        Mode::Adaptive | Mode::Baked => {}
        Mode::Gems => refuse(
            optics.colour == Colour::Thesis,
            "colour",
            "gems maps wavelengths to RGB without tristimulus values, which the matrices of the texts need",
        ),
    }
    refuse(
        !variant.hoist && matches!(mode, Mode::Pq | Mode::Adaptive),
        "hoist",
        "hoist = false is the full sum as the texts print it; no other mode has such a form",
    );
    found
}
