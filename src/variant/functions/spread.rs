//! `diffraction_spread(wi, wr, spread)`: light from one direction, with wider lobes.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::field::comparison_directions::pool;
use crate::field::reference::{Directions, Reference};
use crate::plan::{Coherence, CoherenceScaling, Optics};
use crate::surface::HeightField;
use crate::tables::lobe_sigma;
use crate::variant::{Cost, Form, Pattern};

use super::lamps::PROBES;
use super::{Arguments, ExactProbe, Function, FunctionKind, StatedError};

/// Wider lobes.
pub static SPREAD: Spread = Spread;

/// Light from one direction, with lobes widened by an argument: `diffraction_spread(wi, wr, spread)`.
pub struct Spread;

/// Spreads of probes, in standard deviations of the narrowest lobe: none, within the first step, near a level, beyond it.
const SPREADS: [f64; 4] = [0.0, 0.8, 1.7, 3.5];

impl Function for Spread {
    fn name(&self) -> &'static str {
        "diffraction_spread"
    }

    fn tristimulus_name(&self) -> &'static str {
        "tristimulus_spread"
    }

    fn signature(&self) -> &'static str {
        "(wi: vec3f, wr: vec3f, spread: f32) -> vec3f"
    }

    fn arguments(&self) -> &'static str {
        "wi: unit vector to the light; wr: unit vector to the viewer; both point away from the surface; spread: standard deviation that widens lobes, in direction cosines, from 0; beyond the widest table lobes are as wide as there"
    }

    fn kind(&self) -> FunctionKind {
        FunctionKind::Spread
    }

    fn unit(&self, form: &Form) -> &'static str {
        form.unit()
    }

    /// Two levels, and a texel with the sizes of each but the narrowest.
    fn cost(&self, form: &Form) -> Cost {
        let one = form.cost();
        Cost { fetches: 2 * one.fetches + 2, fetches_mean: 2.0 * one.fetches_mean + 2.0, ..one }
    }

    fn errors(&self, form: &Form) -> Vec<StatedError> {
        let Form::Baked(form) = form else { return Vec::new() };
        form.spread_error().into_iter().collect()
    }

    fn probe_count(&self) -> usize {
        PROBES
    }

    /// For each spread those directions of each kind of the comparison's pool where a flipped bitangent shows most. Time: an exact field
    /// for each spread.
    fn probes(
        &self,
        height: &HeightField,
        rotate_deg: f64,
        optics: &Optics,
    ) -> Result<Vec<ExactProbe>> {
        let kinds = pool(height, optics, rotate_deg);
        let all = kinds.concat();
        let both: Vec<Directions> = all.iter().copied().chain(all.iter().map(flipped)).collect();
        let mut found = Vec::with_capacity(PROBES);
        for width in SPREADS {
            let spread = f64::from((width * lobe_sigma(optics.into())) as f32);
            let colours = widened(height, rotate_deg, optics, spread, &both)?;
            let (right, wrong) = colours.split_at(all.len());
            let mut first = 0;
            for (kind, count) in kinds.iter().zip(OF_EACH) {
                let mut own: Vec<usize> = (first..first + kind.len()).collect();
                // most different first; near the mirror direction nothing differs
                let difference = |i: usize| (right[i][1] - wrong[i][1]).abs();
                own.sort_by(|a, b| difference(*b).total_cmp(&difference(*a)));
                found.extend(own.into_iter().take(count).map(|i| ExactProbe {
                    arguments: Arguments::Spread { directions: all[i], spread },
                    pattern: Pattern::NONE,
                    xyz: right[i],
                }));
                first += kind.len();
            }
        }
        if found.len() < PROBES {
            let cause = format!("only {} of {PROBES} directions to choose from", found.len());
            return Err(Error::new("probe.json", cause));
        }
        Ok(found)
    }
}

/// The same directions in a frame whose bitangent is flipped.
fn flipped(Directions { wi, wr }: &Directions) -> Directions {
    let flip = DVec3::new(1.0, -1.0, 1.0);
    Directions { wi: flip * *wi, wr: flip * *wr }
}

/// Probes of a spread: near the mirror direction, on strong orders, anywhere.
const OF_EACH: [usize; 3] = [1, 2, 1];

/// Exact colours of lobes that are wider by a standard deviation in direction cosines.
///
/// The window's intensity `exp(-|f - f_rs|²/σf²)` has the standard deviation `σf/√2`, so a spread `σ` makes of `σf²` the sum
/// `σf² + 2(σ/λ)²`, and to keep energy the colours are multiplied by the ratio of both. With a coherence length that is
/// proportional to the wavelength this ratio is the same for all wavelengths, and the wider window is a shorter coherence
/// length. It is an error if the optics do not add intensities under such a window.
pub fn widened(
    height: &HeightField,
    rotate_deg: f64,
    optics: &Optics,
    spread: f64,
    directions: &[Directions],
) -> Result<Vec<[f64; 3]>> {
    if optics.coherence != Coherence::Ensemble
        || optics.coherence_scaling != CoherenceScaling::Wavelength
    {
        let cause = "only with coherence = \"ensemble\" and coherence_scaling = \"wavelength\" is a spread a shorter coherence length";
        return Err(Error::new("a spread", cause));
    }
    let variance = 1.0 + (spread / lobe_sigma(optics.into())).powi(2);
    let wider = Optics { coherence_um: optics.coherence_um / variance.sqrt(), ..optics.clone() };
    let visible = Reference::VISIBLE_NM;
    let reference =
        Reference::new(height, rotate_deg, &wider, visible, directions.iter().copied())?;
    let colours = reference.tristimulus_all(directions);
    Ok(colours.into_iter().map(|xyz| xyz.map(|c| c / variance)).collect())
}
