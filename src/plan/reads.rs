//! Which keys a variant reads.

use super::mode::{When, declared};
use super::{Auto, LightFunction, Material, Mode, Reconstruction, Variant};

impl When {
    fn holds(self, variant: &Variant) -> bool {
        match self {
            When::ChoosesTerms => variant.terms == Auto::Auto,
            When::IsPrefiltered => is_prefiltered(variant),
            When::SumsBins => !is_prefiltered(variant),
            When::HasRange => variant.wavelengths.max_nm > variant.wavelengths.min_nm,
            When::CountsReplicas => variant.periods.is_none(),
            When::AcceptsError => variant.accept_error,
            When::HasSurroundings => variant.lights.contains(&LightFunction::Environment),
            When::HasPattern => variant.pattern,
            When::HasPaths => variant.lights.contains(&LightFunction::Path),
            When::ChoosesNodes => {
                When::HasSurroundings.holds(variant) && variant.nodes == Auto::Auto
            }
            When::HasSpread => variant.spread_levels != Auto::Value(0),
            When::HasCells => {
                When::HasSpread.holds(variant) && When::HasSurroundings.holds(variant)
            }
            When::IsDielectric => variant.optics.material == Material::Dielectric,
            When::HasMatter => !variant.optics.is_plain(),
        }
    }
}

pub(super) fn is_prefiltered(variant: &Variant) -> bool {
    variant.reconstruction == Reconstruction::Prefiltered
}

/// Whether a variant reads an entry of the canonical configuration.
pub(super) fn reads(variant: &Variant, key: &str) -> bool {
    let declared = declared(variant.mode);
    let is_such = |(known, when): &(&str, When)| *known == key && when.holds(variant);
    declared.always_reads(key) || declared.sometimes.iter().copied().flatten().any(is_such)
}

/// Whether variants of a mode may read an entry.
pub(super) fn declares(mode: Mode, key: &str) -> bool {
    let declared = declared(mode);
    declared.always_reads(key)
        || declared.sometimes.iter().copied().flatten().any(|(known, _)| *known == key)
}
