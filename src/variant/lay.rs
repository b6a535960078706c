//! Common parts of forms when they are set up on a surface.

use crate::error::Result;
use crate::field::transform::Bins;
use crate::optics::Matter;
use crate::plan::{Auto, Basis, Variant};
use crate::surface::HeightField;
use crate::tables::{Choice, LaidExpansion};

use super::judge::{Light, judge};

/// The configured basis on a surface. It is an error if it is not good enough there.
pub(super) fn expansion(
    variant: &Variant,
    height: &HeightField,
    matter: &Matter,
) -> Result<LaidExpansion> {
    let choice = match variant.terms {
        // for a given number of terms, the basis is optimised for colours
        Auto::Value(terms) if variant.basis == Basis::Optimal => Choice::Seen {
            terms,
            illuminant: variant.optics.illuminant.clone(),
            max_nm: variant.wavelengths.max_nm,
        },
        Auto::Value(terms) => Choice::Count(terms),
        Auto::Auto => Choice::Error(variant.term_error),
    };
    let laid = LaidExpansion::new(variant.basis, choice, range_nm(variant), matter, height)?;
    let light = Light::new(variant)?;
    let is_accepted = judge(variant, height, matter, &laid, &light)?;
    let seen_error = light.seen_error(laid.get(), matter);
    Ok(laid.judged(seen_error, is_accepted))
}

/// Size of the patch, µm.
pub(super) fn patch_um(height: &HeightField) -> [f64; 2] {
    [height.size_x_um(), height.size_y_um()]
}

/// Range of the heights, µm.
pub(super) fn height_range_um(height: &HeightField) -> f64 {
    let (low_um, high_um) = height.range_um();
    high_um - low_um
}

/// Range of the wavelengths, nm.
pub(super) fn range_nm(variant: &Variant) -> [f64; 2] {
    [variant.wavelengths.min_nm, variant.wavelengths.max_nm]
}

/// Bins that directions can reach (|u| and |v| are at most 2), with a margin along x and y.
pub(super) fn bins(size_um: [f64; 2], min_nm: f64, margin: [usize; 2]) -> Bins {
    let [x, y] = margin.map(|m| Bins::reachable(size_um[0], size_um[1], 2.0 / (min_nm * 1e-3), m));
    Bins { r_max: x.r_max, s_max: y.s_max }
}

/// The minimum number of bins to each side, from `min` to 64, for which `tail` is at most `wanted`.
pub(super) fn radius(min: u32, wanted: f64, tail: impl Fn(u32) -> f64) -> u32 {
    const MAX_RADIUS: u32 = 64;
    (min..=MAX_RADIUS).find(|&radius| tail(radius) <= wanted).unwrap_or(MAX_RADIUS)
}
