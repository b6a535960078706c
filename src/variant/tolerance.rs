//! The one table of what results may differ by: comparisons and probes read it.

use std::f64::consts::{FRAC_2_PI, TAU};

use serde::{Deserialize, Serialize};

use crate::plan::{Basis, TableFormat};
use crate::tables::Series;

use super::Form;

/// Which error a comparison shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// Everything: against the exact reference.
    Total,
    /// The variant's approximation in f64, tables not rounded, against the exact reference.
    Model,
    /// What rounding the tables adds, in f64.
    Packing,
    /// What the driver's 32-bit arithmetic adds, on the same tables.
    Arithmetic,
    /// One route against another.
    Across,
}

/// The greatest values that pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tolerance {
    /// Of `max_abs`; none: not judged.
    pub max_abs: Option<f64>,
    /// Of the 95th percentile of CIEDE2000; none: not judged.
    pub de2000_p95: Option<f64>,
    /// The same of the map alone.
    pub map_p95: Option<f64>,
}

impl Tolerance {
    /// Whether measured differences are inside, the 95th percentiles of all directions and of the map; what is not judged is.
    pub fn contains(&self, max_abs: f64, [p95, map_p95]: [f64; 2]) -> bool {
        let inside = |most: Option<f64>, value: f64| most.is_none_or(|most| value <= most);
        inside(self.max_abs, max_abs)
            && inside(self.de2000_p95, p95)
            && inside(self.map_p95, map_p95)
    }
}

/// Arithmetic in 32 bits of a series about the mid-range height, over the greatest value.
pub const CENTRED: f64 = 2e-5;
/// The same of a place between texels: around the mirror direction `(u, v)` is a difference of numbers near 1, whose rounding
/// moves the place where the amplitude is steepest (2.9e-5 on a scan of 65 µm).
const PLACED: f64 = 6e-5;
/// The same of a table of colours: the last bit of a direction is a small part of a column, and lobes are steep (4.5e-5).
const BAKED: f64 = 1e-4;
/// Two drivers' arithmetic against each other, over the greatest value.
pub const ACROSS: f64 = 1e-5;
/// Rounding of tables of 32-bit floats, over the greatest value.
const F32: f64 = 2e-6;
/// The same of terms about the lowest height, which cancel, so that their rounding shows more (3.6e-6).
const F32_FROM_ZERO: f64 = 1e-5;
/// Rounding of tables of 16-bit floats with a scale for each term (1.0e-2 on domes of 0.3 µm). Rounding shows the less, the
/// more bins there are to average over: it is a hundredth of its a-priori bound, which the manifest states.
const F16: f64 = 2e-2;
/// The same of colours.
const BAKED_F16: f64 = 1e-3;
/// Rounding of colours to nine bits of the largest component.
const RGB9E5: f64 = 2e-3;
/// Greatest error of the phase function of a series that counts as converged.
const CONVERGED: f64 = 1e-2;
/// Relative part of a probe's tolerance, of the direction's own greatest value: the flanks of a lobe are steep, so that the
/// rounding of a direction counts there.
const OWN: f64 = 1e-3;
/// The same of a table of colours: filters of graphics cards round their weights to 8 bits.
const OWN_BAKED: f64 = 4e-3;

/// What a form promises, from which every [`Tolerance`] follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise {
    /// Of 32-bit arithmetic, over the greatest value.
    arithmetic: f64,
    /// Of two drivers against each other.
    across: f64,
    /// Of rounding the tables.
    packing: f64,
    /// 95th percentiles of CIEDE2000 against the exact colours, of all directions and of the map; none where nothing is
    /// promised about them.
    model: Option<(f64, Option<f64>)>,
    /// Of a probe, over its own greatest value.
    own: f64,
    /// Sum of the terms' greatest values.
    terms_sum: f64,
}

impl Promise {
    /// Of a shader that reads no terms and claims no error.
    pub(super) fn comparator() -> Promise {
        Promise {
            arithmetic: CENTRED,
            across: ACROSS,
            packing: F32,
            model: None,
            own: OWN,
            terms_sum: 0.0,
        }
    }

    /// Of a series; `filters`: read between texels through the linear filter.
    pub(super) fn of_series(series: &Series, filters: bool) -> Promise {
        let (arithmetic, across) = match series.grid {
            Some(_) => (PLACED, PLACED),
            None => (CENTRED, ACROSS),
        };
        let from_zero = series.expansion().basis == Basis::TaylorZero;
        // terms about the lowest height reach x^n/n!, x = z_max H, before they cancel; each is rounded to 24 bits
        let cancelled = if from_zero { series.terms_sum() * 2.0_f64.powi(-24) } else { 0.0 };
        let least = cancelled.max(filter(series, filters));
        Promise {
            arithmetic: arithmetic.max(least),
            across: across.max(2.0 * least),
            packing: match series.format {
                TableFormat::F32 if from_zero => F32_FROM_ZERO,
                TableFormat::F32 => F32,
                TableFormat::F16 => F16,
                TableFormat::Rgb9e5 => RGB9E5,
            },
            model: None,
            own: OWN,
            terms_sum: series.terms_sum(),
        }
    }

    /// Of colours in a table.
    pub(super) fn of_colours(format: TableFormat) -> Promise {
        Promise {
            arithmetic: BAKED,
            packing: match format {
                TableFormat::F32 => F32,
                TableFormat::F16 => BAKED_F16,
                TableFormat::Rgb9e5 => RGB9E5,
            },
            own: OWN_BAKED,
            ..Promise::comparator()
        }
    }

    /// With the 95th percentiles of a series that has converged, over the whole range of visible light; otherwise nothing is
    /// promised.
    pub(super) fn converged(
        self,
        series: &Series,
        range_nm: [f64; 2],
        model: (f64, Option<f64>),
    ) -> Promise {
        let kept = series.expansion().bound() <= CONVERGED && is_visible(range_nm);
        Promise { model: kept.then_some(model), ..self }
    }

    /// With these 95th percentiles.
    pub(super) fn with_model(self, model: Option<(f64, Option<f64>)>) -> Promise {
        Promise { model, ..self }
    }

    /// What a comparison may differ by. `None` where nothing is promised: a comparator, a series that the plan cuts short,
    /// steps of the wavelength that miss what they sum.
    pub fn tolerance(&self, part: Part) -> Option<Tolerance> {
        let values =
            |max_abs| Some(Tolerance { max_abs: Some(max_abs), de2000_p95: None, map_p95: None });
        match part {
            Part::Arithmetic => values(self.arithmetic),
            Part::Across => values(self.across),
            Part::Packing => values(self.packing),
            Part::Model | Part::Total => self.model.map(|(p95, map_p95)| Tolerance {
                max_abs: None,
                de2000_p95: Some(p95),
                map_p95,
            }),
        }
    }
}

/// Whether a range covers visible light, nm.
pub(super) fn is_visible([min_nm, max_nm]: [f64; 2]) -> bool {
    min_nm <= 380.0 && max_nm >= 780.0
}

/// Drivers may round the weights of a linear filter to 8 bits: an error of 1/512 of the difference of neighbouring texels on
/// each axis. Under a Gaussian window the amplitude changes by `2π⟨|x|⟩/size = 2π √(2/π) σs/size` from a texel to the next
/// at most, the intensity twice that of its peak. Software drivers, which filter floats in 32 bits, stay below 1e-4.
fn filter(series: &Series, filters: bool) -> f64 {
    let Some(grid) = series.grid.filter(|_| filters) else { return 0.0 };
    let change = |size_um: f64| TAU * FRAC_2_PI.sqrt() * grid.sigma_um / size_um;
    2.0 / 512.0 * grid.size_um.map(change).iter().sum::<f64>()
}

/// How far each of X, Y and Z of a probe may lie from `expected` in a shader of 32-bit floats: the larger of 1e-3 of the
/// direction's own greatest value (4e-3 of `baked`) and, of the greatest value of all probes, 2e-5 or twice the sum of the
/// terms' greatest values in units of 2⁻²⁴, where that is larger. The latter counts for a series about the lowest height,
/// whose large terms cancel.
pub fn probe_tolerances(form: &Form, expected: &[[f64; 3]]) -> Vec<f64> {
    let Promise { own, terms_sum, .. } = form.promise();
    let greatest = |xyz: &[f64; 3]| xyz.iter().fold(0.0, |max: f64, v| max.max(v.abs()));
    let share = (terms_sum * 2.0_f64.powi(-23)).clamp(CENTRED, 1.0);
    let floor = share * expected.iter().map(greatest).fold(f64::MIN_POSITIVE, f64::max);
    expected.iter().map(|xyz| floor.max(own * greatest(xyz))).collect()
}
