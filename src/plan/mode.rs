//! What a variant can compute: the modes, which keys each of them reads, and the combinations that mean nothing.

use serde::{Deserialize, Serialize};

use super::variants::Draft;
use super::words::{Words, word_of};
use super::{
    Basis, Coherence, CoherenceScaling, Colour, Optics, Reconstruction, Sampling, TableFormat,
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
    ("full", Some(Mode::Full)),
    ("pq", Some(Mode::Pq)),
    ("adaptive", Some(Mode::Adaptive)),
    ("gems", Some(Mode::Gems)),
    ("baked", Some(Mode::Baked)),
];

impl Mode {
    /// Every mode, in the order of the manual.
    pub fn all() -> impl Iterator<Item = Mode> {
        MODES.iter().filter_map(|(_, mode)| *mode)
    }

    /// The word of the plan.
    pub fn as_str(self) -> &'static str {
        word_of(MODES, self)
    }
}

/// Whether a mode reads a key of the canonical configuration; `pq` with given periods has no use for a coherence length.
pub(super) fn reads(mode: Mode, periods_given: bool, key: &str) -> bool {
    match (mode, key) {
        (Mode::Full, _) | (_, "mode") => true,
        (Mode::Pq, "coherence" | "coherence_scaling" | "hoist") => false,
        (Mode::Pq, "coherence_um") => !periods_given,
        (Mode::Adaptive, "window_radius" | "step_nm" | "hoist") => false,
        (Mode::Pq | Mode::Adaptive, _) => true,
        (Mode::Baked, "basis" | "terms" | "window_radius" | "step_nm" | "packing" | "hoist") => {
            false
        }
        (Mode::Baked, _) => true,
        (Mode::Gems, _) => false,
    }
}

/// Whether a form reads what lies between the texels of a table.
pub(super) fn reads_between(mode: Mode, reconstruction: Option<Reconstruction>) -> bool {
    let prefiltered = reconstruction == Some(Reconstruction::Prefiltered);
    match mode {
        Mode::Full | Mode::Adaptive => prefiltered,
        Mode::Baked => true,
        Mode::Pq | Mode::Gems => false,
    }
}

/// The same configuration with every key that its mode does not read at its documented default, except where
/// [`broken`] has to see it.
pub(super) fn normalised(draft: Draft) -> Draft {
    let standard = Draft::standard(Optics::standard());
    let mut draft = draft;
    if draft.mode.1 != Some(Mode::Baked) {
        draft.bake_error = standard.bake_error;
        draft.bake_mib = standard.bake_mib;
    }
    if draft.mode.1.is_some_and(|mode| !reads_between(mode, draft.reconstruction.1)) {
        draft.sampling = standard.sampling;
    }
    if draft.reconstruction.1 == Some(Reconstruction::Prefiltered) {
        draft.window_radius = standard.window_radius;
    }
    match draft.mode.1 {
        Some(Mode::Full) => Draft { periods: None, ..draft },
        Some(Mode::Pq) if draft.periods.is_some() => {
            let coherence_um = standard.optics.coherence_um;
            Draft { optics: Optics { coherence_um, ..draft.optics.clone() }, ..draft }
        }
        Some(Mode::Adaptive) => {
            let mut draft = Draft { periods: None, window_radius: standard.window_radius, ..draft };
            draft.wavelengths.step_nm = standard.wavelengths.step_nm;
            draft
        }
        Some(Mode::Baked) => {
            let Draft {
                mode, mut wavelengths, table, sampling, bake_error, bake_mib, optics, ..
            } = draft;
            // an only wavelength is refused
            wavelengths.step_nm = standard.wavelengths.step_nm;
            Draft { mode, wavelengths, table, sampling, bake_error, bake_mib, optics, ..standard }
        }
        Some(Mode::Gems) => {
            let colour = draft.optics.colour;
            Draft { mode: draft.mode, optics: Optics { colour, ..standard.optics }, ..standard }
        }
        Some(Mode::Pq) | None => draft,
    }
}

/// The constraints that a configuration breaks: the key, and the reason.
pub(super) fn broken(mode: Mode, draft: &Draft) -> Vec<(&'static str, String)> {
    let optics = &draft.optics;
    let ensemble = optics.coherence == Coherence::Ensemble;
    let mut found = Vec::new();
    let mut refuse = |when: bool, key: &'static str, reason: &str| {
        if when {
            found.push((key, reason.to_owned()));
        }
    };
    let prefiltered = draft.reconstruction.1 == Some(Reconstruction::Prefiltered);
    let reads_between = reads_between(mode, draft.reconstruction.1);
    refuse(
        reads_between
            && draft.sampling == Sampling::Filter
            && draft.table.1 == Some(TableFormat::F32),
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
        prefiltered && !draft.hoist,
        "hoist",
        "hoist = false is the loop of the texts over bins, and a prefiltered table needs no such loop",
    );
    refuse(
        mode != Mode::Baked && draft.table.1 == Some(TableFormat::Rgb9e5),
        "table",
        "numbers with a shared exponent have no sign, and only the colours of mode = \"baked\" need none",
    );
    refuse(
        mode == Mode::Baked && draft.wavelengths.max_nm <= draft.wavelengths.min_nm,
        "wavelengths",
        "baked integrates over the wavelengths, and a single one leaves nothing to integrate",
    );
    let tabulated = matches!(draft.basis.1, Some(Basis::Chebyshev | Basis::Optimal));
    refuse(
        tabulated && !draft.hoist && mode == Mode::Full && !prefiltered,
        "basis",
        "hoist = false is the loop of the texts over powers, and the coefficients of this basis are no powers",
    );
    match mode {
        Mode::Full => refuse(
            ensemble && !draft.hoist,
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
        !draft.hoist && matches!(mode, Mode::Pq | Mode::Adaptive),
        "hoist",
        "hoist = false is the full sum as the texts print it; no other mode has such a form",
    );
    found
}
