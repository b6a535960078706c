//! Combinations that mean nothing, and keys that a variant leaves alone.

use super::axis::Entry;
use super::mode::declared;
use super::reads::{is_prefiltered, reads};
use super::variant::axes;
use super::{Basis, Coherence, CoherenceScaling, Colour, Mode, Optics, TableFormat, Variant};

/// Sets every entry that a variant does not read to its documented default, except where [`broken`] has to see it.
pub(super) fn normalise(variant: &mut Variant) {
    let standard = Variant::standard(&Optics::standard());
    let refused = declared(variant.mode).refused;
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
        Mode::Gems => refuse(
            optics.colour == Colour::Thesis,
            "colour",
            "gems maps wavelengths to RGB without tristimulus values, which the matrices of the texts need",
        ),
        _ => {}
    }
    refuse(
        !variant.hoist && matches!(mode, Mode::Pq | Mode::Adaptive),
        "hoist",
        "hoist = false is the full sum as the texts print it; no other mode has such a form",
    );
    found
}
