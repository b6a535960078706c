//! The only table of tolerances. Comparisons and probes read it.

use std::f64::consts::{FRAC_2_PI, TAU};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::light::{Light, Lights};
use crate::plan::{Basis, TableFormat};
use crate::tables::Series;

use super::{Arguments, Form, mirrored};

/// The part of the error that a comparison shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// The total error against the exact reference.
    Total,
    /// The error of the variant's approximation: in f64, with unrounded tables, against the exact reference.
    Model,
    /// The error added by rounding the tables, in f64.
    Packing,
    /// The error added by the driver's 32-bit arithmetic, on the same tables.
    Arithmetic,
    /// The difference between two routes.
    Across,
}

/// Maximum values that pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tolerance {
    /// Maximum of `max_abs`. `None`: not judged.
    pub max_abs: Option<f64>,
    /// Maximum of the 95th percentile of CIEDE2000. `None`: not judged.
    pub de2000_p95: Option<f64>,
    /// The same for the map alone.
    pub map_p95: Option<f64>,
}

impl Tolerance {
    /// Whether measured differences are within the tolerance. `[p95, map_p95]`: 95th percentiles of all directions and
    /// of the map. Values that are not judged pass.
    pub fn contains(&self, max_abs: f64, [p95, map_p95]: [f64; 2]) -> bool {
        let inside = |limit: Option<f64>, value: f64| limit.is_none_or(|limit| value <= limit);
        inside(self.max_abs, max_abs)
            && inside(self.de2000_p95, p95)
            && inside(self.map_p95, map_p95)
    }
}

/// 32-bit arithmetic of a series about the mid-range height, relative to the maximum.
pub const CENTRED: f64 = 2e-5;
/// The same for interpolation between texels. Around the mirror direction `(u, v)` is a difference of numbers near 1,
/// and its rounding error moves the position where the amplitude is steepest (2.9e-5 on a scan of 65 µm).
const PLACED: f64 = 6e-5;
/// The same for a table of colours: the last bit of a direction is a small part of a column, but lobes are steep (4.5e-5).
const BAKED: f64 = 1e-4;
/// Difference between the arithmetic of two drivers, relative to the maximum.
pub const ACROSS: f64 = 1e-5;
/// Rounding of tables of 32-bit floats, relative to the maximum.
const F32: f64 = 2e-6;
/// The same for terms about the lowest height. They cancel, so their rounding errors weigh more (3.6e-6).
const F32_FROM_ZERO: f64 = 1e-5;
/// Rounding of tables of 16-bit floats with a scale for each term (1.0e-2 on domes of 0.3 µm). With more bins, rounding
/// errors average out more: here the error is a hundredth of the a-priori bound in the manifest.
const F16: f64 = 2e-2;
/// The same for colours.
const BAKED_F16: f64 = 1e-3;
/// Rounding of colours to nine bits of the largest component.
const RGB9E5: f64 = 2e-3;
/// Maximum error of the phase function for a series to count as converged.
const CONVERGED: f64 = 1e-2;
/// Relative part of a probe's tolerance: it is multiplied by the direction's own maximum. The flanks of a lobe are
/// steep, so the rounding of a direction matters there.
const OWN: f64 = 1e-3;
/// The same for a table of colours: filters of graphics cards round their weights to 8 bits.
const OWN_BAKED: f64 = 4e-3;

/// The errors that a form promises to keep. Every [`Tolerance`] follows from them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise {
    /// Error of 32-bit arithmetic, relative to the maximum.
    arithmetic: f64,
    /// Difference between two drivers.
    across: f64,
    /// Error of rounding the tables.
    packing: f64,
    /// 95th percentiles of CIEDE2000 against the exact colours, of all directions and of the map. `None` if they are
    /// not promised.
    model: Option<(f64, Option<f64>)>,
    /// Error of a probe, relative to its own maximum.
    own: f64,
    /// Sum of the terms' maxima.
    terms_sum: f64,
}

impl Promise {
    /// The promise of a shader that does not read terms and does not claim an error.
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

    /// The promise of a series. `filters`: its table is read between texels through the linear filter.
    pub(super) fn of_series(series: &Series, filters: bool) -> Promise {
        let (arithmetic, across) = match series.grid {
            Some(_) => (PLACED, PLACED),
            None => (CENTRED, ACROSS),
        };
        let from_zero = series.expansion().basis == Basis::TaylorZero;
        // terms about the lowest height reach x^n/n!, x = z_max H, before they cancel, and each is rounded to 24 bits
        let cancelled = if from_zero { series.terms_sum() * 2.0_f64.powi(-24) } else { 0.0 };
        let floor = cancelled.max(filter(series, filters));
        Promise {
            arithmetic: arithmetic.max(floor),
            across: across.max(2.0 * floor),
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

    /// The promise of colours in a table.
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

    /// Adds the 95th percentiles if the series has converged and the range covers visible light. Otherwise no colours
    /// are promised.
    pub(super) fn converged(
        self,
        series: &Series,
        range_nm: [f64; 2],
        model: (f64, Option<f64>),
    ) -> Promise {
        let kept = series.expansion().bound() <= CONVERGED && is_visible(range_nm);
        Promise { model: kept.then_some(model), ..self }
    }

    /// Sets the 95th percentiles.
    pub(super) fn with_model(self, model: Option<(f64, Option<f64>)>) -> Promise {
        Promise { model, ..self }
    }

    /// The tolerance of a comparison. `None` if no error is promised: for a comparator, for a series with too few
    /// terms, and for wavelength steps that miss lobes.
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

/// Error of a linear filter. Drivers may round its weights to 8 bits, which is an error of 1/512 of the difference
/// between neighbouring texels on each axis. Under a Gaussian window the amplitude changes by at most `2π⟨|x|⟩/size =
/// 2π √(2/π) σs/size` from a texel to the next, and the intensity by twice that, relative to the peak. Software
/// drivers, which filter floats in 32 bits, stay below 1e-4.
fn filter(series: &Series, filters: bool) -> f64 {
    let Some(grid) = series.grid.filter(|_| filters) else { return 0.0 };
    let change = |size_um: f64| TAU * FRAC_2_PI.sqrt() * grid.sigma_um / size_um;
    2.0 / 512.0 * grid.size_um.map(change).iter().sum::<f64>()
}

/// Maximum difference of each of X, Y and Z of a probe from `expected` in a shader of 32-bit floats. It is the larger
/// of two numbers: 1e-3 (4e-3 for `baked`) times the direction's own maximum; and the maximum of all probes, times the
/// larger of 2e-5 and twice the sum of the terms' maxima in units of 2⁻²⁴. That sum matters for a series about the
/// lowest height, whose large terms cancel.
///
/// The maximum is that of the exact colours, so that a diverged result does not excuse itself. Where the unit of the
/// result is arbitrary, or the plan accepts an error above the limit, it is that of `expected`.
pub fn probe_tolerances(form: &Form, exact: &[[f64; 3]], expected: &[[f64; 3]]) -> Vec<f64> {
    let Promise { own, terms_sum, .. } = form.promise();
    let largest = |xyz: &[f64; 3]| xyz.iter().fold(0.0, |max: f64, v| max.max(v.abs()));
    let share = (terms_sum * 2.0_f64.powi(-23)).clamp(CENTRED, 1.0);
    let of_all = |all: &[[f64; 3]]| all.iter().map(largest).fold(f64::MIN_POSITIVE, f64::max);
    let max = if form.claims_truth() { of_all(exact) } else { of_all(expected) };
    expected.iter().map(|xyz| (share * max).max(own * largest(xyz).min(max))).collect()
}

/// 32-bit arithmetic of lights with a size, relative to the result: a narrow light is a small difference of wavelengths.
const OWN_LIGHT: f64 = 2e-3;

/// Maximum difference of each of X, Y and Z of a call of a function of wider lobes or of lights with a size from `expected`
/// in a shader of 32-bit floats: the larger of 2e-3 of the result's own maximum, 4e-3 for `baked`, and of 2e-5 of what a
/// mirror of the material shows, 1e-4 under surroundings.
pub fn light_tolerance(form: &Form, arguments: &Arguments, expected: &[f64; 3]) -> f64 {
    let largest = expected.iter().fold(0.0, |max: f64, v| max.max(v.abs()));
    let centred = match arguments {
        // the filter's weights have 8 bits, and the surroundings of probes change by a twentieth between texels
        Arguments::Environment { .. } => 5.0 * CENTRED,
        _ => CENTRED,
    };
    let most = match (*arguments, form) {
        // the peak of the widened lobe
        (Arguments::Spread { spread, .. }, Form::Baked(baked)) => {
            let narrowest = baked.wide.as_ref().map_or(1.0, |wide| wide.lobe_sigma);
            1.0 / (1.0 + (spread / narrowest).powi(2))
        }
        _ => mirrored(arguments, form.matter()),
    };
    (OWN_LIGHT.max(form.promise().own) * largest).max(centred * most)
}

/// 32-bit arithmetic under lights with a size, relative to the maximum (4e-5 under the sun).
const LIGHT_ARITHMETIC: f64 = 1e-4;
/// The same under surroundings: drivers may round the weights of a linear filter to 8 bits, and neighbouring texels at the edge of
/// a softbox differ by its radiance (software drivers stay below 2e-5).
const AROUND_ARITHMETIC: f64 = 2e-3;
/// Rounding of the tables under lights with a size, relative to the maximum.
const LIGHT_PACKING: f64 = 2e-5;
/// The same where the reflectance depends on the wavelength: cubics over shorter ranges of wavelengths, whose moments are
/// smaller differences (1.5e-4 on gold under polycarbonate, CIEDE2000 below 0.001).
const LIGHT_PACKING_OF_MATTER: f64 = 3e-4;

/// The tolerance of a comparison under lights. It is that of the widest error among them. `None` as for a
/// comparison under one direction.
pub fn tolerance_under(form: &Form, lights: &Lights, part: Part) -> Option<Tolerance> {
    let values =
        |max_abs| Some(Tolerance { max_abs: Some(max_abs), de2000_p95: None, map_p95: None });
    let of_direction = form.promise().tolerance(part);
    if lights.with_size().next().is_none() {
        return of_direction;
    }
    match part {
        Part::Arithmetic | Part::Across if lights.all.iter().any(Light::is_all_round) => {
            values(AROUND_ARITHMETIC)
        }
        Part::Arithmetic | Part::Across => values(LIGHT_ARITHMETIC),
        // of a table of colours the same numbers are read
        Part::Packing if matches!(form, Form::Baked(_)) => of_direction,
        Part::Packing if form.matter().is_plain() => values(LIGHT_PACKING),
        Part::Packing => values(LIGHT_PACKING_OF_MATTER),
        Part::Model | Part::Total => {
            let single = of_direction?.de2000_p95?;
            let of = |light: &Light| {
                let calls = Arguments::under(light, DVec3::Z);
                let errors = calls.iter().flat_map(|(call, _)| call.kind().function().errors(form));
                errors.map(|error| error.de2000_p95).fold(0.0, f64::max)
            };
            let mut most = lights.with_size().map(of).fold(0.0, f64::max);
            if lights.directions().next().is_some() {
                most = most.max(single);
            }
            Some(Tolerance { max_abs: None, de2000_p95: Some(most), map_p95: Some(most) })
        }
    }
}

/// Maximum root mean square of the difference between the probes' expected and exact colours, relative to that of the
/// exact ones. Measured: at most 2e-3 with wavelengths 5 nm apart, 0.03 for tables of colours, 0.13 with wavelengths 20 nm
/// apart; 0.7 with wavelengths 50 nm apart, which miss most lobes; above 0.9 for series that diverge.
pub const MAX_PROBE_ERROR: f64 = 0.5;

/// The root mean square of the difference between the probes' expected and exact colours, relative to that of the exact
/// ones. `None` where they need not agree: in an arbitrary unit, or for finite replicas, whose lobes have another shape.
pub fn probe_error(form: &Form, exact: &[[f64; 3]], expected: &[[f64; 3]]) -> Option<f64> {
    if form.has_arbitrary_unit() || form.replicas().is_some() {
        return None;
    }
    let square = |sum: f64, x: f64| sum + x * x;
    let differences = exact.iter().zip(expected).flat_map(|(a, b)| (0..3).map(|c| a[c] - b[c]));
    let all = exact.iter().flatten().copied().fold(0.0, square);
    let error = (differences.fold(0.0, square) / all).sqrt();
    (all > 0.0).then_some(error)
}
