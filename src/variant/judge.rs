//! Whether a series is good enough to be built, and what would be.

use crate::error::{Error, Result};
use crate::optics::Matter;
use crate::optics::spectrum::{Sample, Spectrum};
use crate::plan::{Auto, Basis, TableFormat, Variant, Wavelengths};
use crate::surface::HeightField;
use crate::surface::facts::{Outliers, outliers};
use crate::tables::basis::{Expansion, MAX_TERMS};
use crate::tables::{Choice, LaidExpansion};

/// Maximum error of the phase function, as colours see it, of a variant that does not state `accept_error = true`.
pub const MAX_PHASE_ERROR: f64 = 0.1;

/// Maximum error by rounding, of the same: bounds of the rounding of terms, which cancel, relative to 1. 32-bit floats
/// round in the shader, too. 16-bit floats round in the table only, and stay at a seventh of the bound (1.0e-2 at a bound
/// of 0.07, on domes of 0.3 µm).
const MAX_ROUNDING: [(TableFormat, f64); 2] = [(TableFormat::F32, 0.025), (TableFormat::F16, 0.7)];

/// Spacing of the wavelengths at which errors are weighed, nm.
const STEP_NM: f64 = 5.0;

/// The light of a variant: its wavelengths with their colour weights.
pub(super) struct Light {
    samples: Vec<Sample>,
}

impl Light {
    /// The light of a variant. It is an error if the eye sees none of it.
    pub(super) fn new(variant: &Variant) -> Result<Light> {
        let Wavelengths { min_nm, max_nm, .. } = variant.wavelengths;
        let illuminant = &variant.optics.illuminant;
        let step_nm = STEP_NM.min(max_nm - min_nm).max(f64::MIN_POSITIVE);
        let range = Wavelengths { min_nm, max_nm, step_nm };
        let samples = Spectrum::new(illuminant)?.samples(&range);
        if samples.iter().any(|sample| sample.xyz.iter().any(|part| *part > 0.0)) {
            return Ok(Light { samples });
        }
        let cause = format!(
            "illuminant {} has no visible light from {min_nm} to {max_nm} nm: every colour would be black",
            illuminant.name()
        );
        Err(Error::new(&variant.name, cause)
            .remedy("use wavelengths between 380 and 780 nm at which the illuminant has power"))
    }

    /// Its X, Y and Z added, in units of the Y of the whole illuminant.
    fn sum(&self) -> f64 {
        self.samples.iter().flat_map(|sample| sample.xyz).sum()
    }

    /// Error of the phase function as colours see it: the error, the same at all wavelengths, that would change X, Y or Z
    /// as much as these errors may. An error ε of an amplitude of at most 1 changes its square by at most 2ε + ε².
    pub(super) fn seen_error(&self, expansion: &Expansion, matter: &Matter) -> f64 {
        let mut sums = [[0.0; 2]; 3];
        for sample in &self.samples {
            // the square of a larger number may be infinite
            let error = expansion.bound_to(matter.max_z(sample.lambda_nm)).min(1e100);
            for (sum, weight) in sums.iter_mut().zip(sample.xyz) {
                *sum = [sum[0] + weight * (2.0 * error + error * error), sum[1] + weight];
            }
        }
        let of_sum = |[change, light]: [f64; 2]| if light > 0.0 { change / light } else { 0.0 };
        // √(1 + x) - 1 without cancellation
        let change = sums.map(of_sum).into_iter().fold(0.0, f64::max);
        change / ((1.0 + change).sqrt() + 1.0)
    }
}

/// Whether the light of a variant is nearly all visible light, so that its colours can be compared with exact ones. A
/// variant of one wavelength is not.
pub fn is_whole_light(variant: &Variant) -> Result<bool> {
    let [min_nm, max_nm] = Wavelengths::VISIBLE_NM;
    let visible = Wavelengths { min_nm, max_nm, step_nm: STEP_NM };
    let all = Light::new(&Variant { wavelengths: visible, ..variant.clone() })?;
    Ok(Light::new(variant)?.sum() >= WHOLE * all.sum())
}

/// Minimum share of visible light that counts as all of it.
const WHOLE: f64 = 0.9;

/// Refuses a series whose error is above the limit, with what would do. Returns whether it is above and accepted.
pub(super) fn judge(
    variant: &Variant,
    height: &HeightField,
    matter: &Matter,
    laid: &LaidExpansion,
    light: &Light,
) -> Result<bool> {
    let expansion = laid.get();
    let (basis, terms) = (variant.basis.as_str(), expansion.terms);
    let range_um = range(height);
    let (bound, wanted) = (expansion.bound(), variant.term_error);
    let cause = if variant.terms == Auto::Auto && bound > wanted {
        format!(
            "the search for terms ended at its maximum: {terms} terms of {basis} have an error of the phase function of \
             {bound:.1e} on heights over {range_um:.3} µm, above term_error = {wanted:e}"
        )
    } else if light.seen_error(expansion, matter) > MAX_PHASE_ERROR {
        format!(
            "{terms} terms of {basis} have an error of the phase function of {:.1e} as colours see it on heights over \
             {range_um:.3} µm, above {MAX_PHASE_ERROR}",
            light.seen_error(expansion, matter)
        )
    } else if let Some((error, limit)) = rounded_away(variant.table, expansion) {
        format!(
            "{terms} terms of {basis} cancel on heights over {range_um:.3} µm: rounded to {} they leave an error of up to \
             {error:.1e}, above {limit}",
            variant.table.as_str()
        )
    } else {
        return Ok(false);
    };
    if variant.accept_error {
        return Ok(true);
    }
    let mut remedies = advice(variant, height, matter, light)?;
    remedies.extend(dust(variant, height, matter, light)?);
    let remedy = format!("{}; accept_error = true builds it all the same", remedies.join("; or "));
    Err(Error::new(&variant.name, cause).remedy(remedy))
}

/// Range of the heights, µm.
fn range(height: &HeightField) -> f64 {
    let (low_um, high_um) = height.range_um();
    high_um - low_um
}

/// The rounding error and its limit, if it is above.
fn rounded_away(format: TableFormat, expansion: &Expansion) -> Option<(f64, f64)> {
    let (_, limit) = MAX_ROUNDING.into_iter().find(|(known, _)| *known == format)?;
    let error = super::bound::rounding(format, expansion.term_sizes().iter().sum());
    (error > limit).then_some((error, limit))
}

/// Numbers of terms that would do on the surface: of the configured basis, and of the basis that needs fewest.
fn advice(
    variant: &Variant,
    height: &HeightField,
    matter: &Matter,
    light: &Light,
) -> Result<Vec<String>> {
    let mut words = Vec::new();
    if let Some(terms) = enough(variant, variant.basis, height, matter, light)? {
        words.push(format!("use terms = {terms}"));
    }
    if variant.basis != Basis::Optimal
        && let Some(terms) = enough(variant, Basis::Optimal, height, matter, light)?
    {
        words.push(format!("use basis = \"optimal\", where terms = {terms} would do"));
    }
    if words.is_empty() {
        let (low_um, high_um) = height.range_um();
        words.push(format!(
            "no basis has enough terms for heights from {low_um:.3} to {high_um:.3} µm: check the unit of the heights, or \
             use mode = \"baked\", which has no terms"
        ));
    }
    Ok(words)
}

/// The minimum number of terms of a basis that is not refused. `None`: no number up to [`MAX_TERMS`].
fn enough(
    variant: &Variant,
    basis: Basis,
    height: &HeightField,
    matter: &Matter,
    light: &Light,
) -> Result<Option<u32>> {
    let Variant { optics, wavelengths, table, .. } = variant;
    let choice = match basis {
        Basis::Optimal => Choice::Seen {
            terms: 1,
            illuminant: optics.illuminant.clone(),
            max_nm: wavelengths.max_nm,
        },
        _ => Choice::Count(1),
    };
    let range_nm = [wavelengths.min_nm, wavelengths.max_nm];
    let laid = LaidExpansion::new(basis, choice, range_nm, matter, height)?;
    let mut expansion = laid.get().clone();
    Ok((1..=MAX_TERMS).find(|terms| {
        expansion.terms = *terms;
        light.seen_error(&expansion, matter) <= MAX_PHASE_ERROR
            && rounded_away(*table, &expansion).is_none()
    }))
}

/// What clipping would do, if a few pixels make most of the height range.
fn dust(
    variant: &Variant,
    height: &HeightField,
    matter: &Matter,
    light: &Light,
) -> Result<Option<String>> {
    let Some(found) = outliers(height)? else { return Ok(None) };
    let Outliers { percent, pixels, share, farthest_um, clipped } = &found;
    let then = match enough(variant, variant.basis, clipped, matter, light)? {
        Some(terms) => format!(", which needs terms = {terms}"),
        None => String::new(),
    };
    Ok(Some(format!(
        "use clip_percent = {percent}{then}: {pixels} pixels ({:.3} %) are dust or spikes, up to {farthest_um:.3} µm outside \
         the range of {:.3} µm of the others",
        100.0 * share,
        range(clipped),
    )))
}
