//! Combinations without a meaning, and keys that a variant does not read.

use super::axis::Entry;
use super::mode::declared;
use super::reads::{is_prefiltered, reads};
use super::variant::axes;
use super::{
    Auto, Basis, Coherence, CoherenceScaling, Colour, LightFunction, Mode, Obliquity, Optics,
    TableFormat, Variant, Wavelengths,
};

/// Sets every entry that a variant does not read to its documented default, except entries that [`broken`] must check.
pub(super) fn normalise(variant: &mut Variant) {
    let standard = Variant::standard(&Optics::standard());
    let refused = declared(variant.mode).refused;
    let entries = axes().flat_map(|axis| axis.entries);
    let is_idle = |key| !reads(variant, key) && !refused.contains(&key);
    let idle: Vec<&Entry> = entries.filter(|entry| is_idle(entry.key)).collect();
    idle.into_iter().for_each(|entry| (entry.copy)(&standard, variant));
}

/// The constraints that a configuration violates, as pairs of key and reason.
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
    let has_paths = variant.lights.contains(&LightFunction::Path);
    let has_size = match mode {
        Mode::Orders => variant.lights != [LightFunction::Direction],
        Mode::Baked => has_paths,
        _ => false,
    };
    let has_levels = variant.spread_levels != Auto::Value(0);
    let is_known = |light: &LightFunction| match light {
        LightFunction::Direction | LightFunction::Path => true,
        LightFunction::Disc | LightFunction::Environment => has_levels,
        LightFunction::Polygon => false,
    };
    refuse(
        mode == Mode::Baked && has_paths && !variant.lights.iter().all(is_known),
        "lights",
        "a table of colours has functions for \"direction\", \"path\" and, with spread_levels, \"disc\" and \"environment\"; the others are of mode = \"orders\"",
    );
    refuse(
        variant.filters() && variant.table == TableFormat::F32,
        "sampling",
        "WebGPU and WebGL2 cannot filter tables of 32-bit floats; use table = \"f16\"",
    );
    refuse(
        prefiltered && mode == Mode::Pq,
        "reconstruction",
        "pq has no coherence window, which a prefiltered table would contain",
    );
    refuse(
        prefiltered && ensemble,
        "coherence",
        "a prefiltered table holds amplitudes under the window, but coherence = \"ensemble\" adds the intensities of orders before the window",
    );
    refuse(
        prefiltered && optics.coherence_scaling == CoherenceScaling::Wavelength,
        "coherence_scaling",
        "a prefiltered table contains one window, the same for all wavelengths, so it needs coherence_scaling = \"fixed\"",
    );
    refuse(
        prefiltered && !variant.hoist,
        "hoist",
        "hoist = false is the texts' loop over bins, and a prefiltered table is read without such a loop",
    );
    refuse(
        mode != Mode::Baked && variant.table == TableFormat::Rgb9e5,
        "table",
        "table = \"rgb9e5\" cannot store negative numbers; only the colours of mode = \"baked\" are never negative",
    );
    refuse(
        mode == Mode::Baked && variant.wavelengths.max_nm <= variant.wavelengths.min_nm,
        "wavelengths",
        "baked integrates over a range of wavelengths; make max_nm larger than min_nm",
    );
    let spreads = mode == Mode::Baked && variant.spread_levels != Auto::Value(0);
    refuse(
        spreads && !ensemble,
        "coherence",
        "wider lobes add the intensities of orders, but coherence = \"single\" adds their amplitudes; use coherence = \"ensemble\", or spread_levels = 0",
    );
    refuse(
        spreads && optics.coherence_scaling == CoherenceScaling::Fixed,
        "coherence_scaling",
        "the lobes of a coherence length that is the same for all wavelengths have a width for each wavelength, and a spread adds the same to all; use coherence_scaling = \"wavelength\" or source_diameter_deg, or spread_levels = 0",
    );
    refuse(
        mode == Mode::Orders && variant.wavelengths.max_nm <= variant.wavelengths.min_nm,
        "wavelengths",
        "an order shows a light with a size at a range of wavelengths; make max_nm larger than min_nm",
    );
    refuse(
        has_size && optics.coherence_scaling == CoherenceScaling::Fixed,
        "coherence_scaling",
        "lights with a size have no meaning with a coherence length that is the same for all wavelengths; use coherence_scaling = \"wavelength\" or source_diameter_deg, or lights = [\"direction\"]",
    );
    let Wavelengths { min_nm, max_nm, .. } = variant.wavelengths;
    refuse(
        max_nm < Wavelengths::VISIBLE_NM[0] || min_nm > Wavelengths::VISIBLE_NM[1],
        "wavelengths",
        "the range has no visible light, which is 380 to 780 nm (CIE 1931 observer): every colour would be black",
    );
    refuse(
        mode == Mode::Baked && optics.obliquity == Obliquity::Unpolarised,
        "obliquity",
        "the share of each polarisation depends on both directions, and a table over (u, v, w) has only their sum; use \"stam\", \"te\" or \"tm\", or another mode",
    );
    let tabulated = matches!(variant.basis, Basis::Chebyshev | Basis::Optimal);
    refuse(
        tabulated && !variant.hoist && mode == Mode::Full && !prefiltered,
        "basis",
        "hoist = false is the texts' loop over powers, and the coefficients of this basis are not powers",
    );
    match mode {
        Mode::Full => refuse(
            ensemble && !variant.hoist,
            "hoist",
            "hoist = false adds the amplitudes of bins term by term, but coherence = \"ensemble\" adds the intensities of bins",
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
                "pq repeats the patch a whole number of times, the same for all wavelengths, so it needs coherence_scaling = \"fixed\"",
            );
        }
        Mode::Gems => refuse(
            optics.colour == Colour::Thesis,
            "colour",
            "gems maps wavelengths directly to RGB, but colour = \"thesis\" needs tristimulus values",
        ),
        _ => {}
    }
    refuse(
        !variant.hoist && matches!(mode, Mode::Pq | Mode::Adaptive),
        "hoist",
        "hoist = false is the full sum as the texts print it; only mode = \"full\" has this form",
    );
    found
}
