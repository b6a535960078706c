//! A-priori bounds of the errors of approximations, valid for every direction.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::field::replicas::{replica_factor, sinc};
use crate::optics;
use crate::plan::{TableFormat, Window};
use crate::tables::Series;

/// Maximum share of the window's energy that `window_radius = "auto"` leaves out.
pub const AUTO_TAIL: f64 = 1e-4;
/// The same for `pq`, whose periodic sinc decreases only with the inverse of the distance.
pub const AUTO_TAIL_PQ: f64 = 1e-2;
/// Maximum `σf·L`, in bins, at which neighbouring lobes count as separate. Above it, amplitudes of neighbouring bins interfere.
pub const ISOLATED: f64 = 0.2;

/// 95th percentile of CIEDE2000 against exact colours with 8 wavelengths per order. It falls with that number to the power
/// -[`FALL`]: 2.5 with 16, 1.0 with 32.
const ERROR_OF_8: f64 = 6.0;
/// See [`ERROR_OF_8`].
const FALL: f64 = 1.29;

/// The error that a number of wavelengths per order keeps.
pub fn environment_error(nodes: u32) -> f64 {
    ERROR_OF_8 * (8.0 / f64::from(nodes)).powf(FALL)
}

/// The least number of wavelengths per order that keeps an error.
pub fn nodes_for(error: f64) -> u32 {
    (2..64).find(|nodes| environment_error(*nodes) <= error).unwrap_or(64)
}

/// A-priori bounds, valid for every direction.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorBound {
    /// Number of terms.
    pub terms: u32,
    /// Maximum error of the phase function caused by the finite number of terms, at any wavelength.
    pub phase_function: f64,
    /// The same as colours see it: the error, the same at all wavelengths, that would change X, Y or Z as much as the errors
    /// of all wavelengths may. Above 0.1 a variant is built only with `accept_error = true`.
    pub phase_function_seen: f64,
    /// Whether an error is above its limit, and the plan accepts that: the colours may be wrong.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub accepted: bool,
    /// Maximum error of a bin's amplitude caused by rounding the terms to the table's format.
    pub packing: f64,
    /// Number of bins to each side of the nearest one. `None` for forms without such a number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window_radius: Option<u32>,
    /// Share of the light that is left out: energy of the coherence window, or light of the replicas in `pq`, beyond
    /// the bins that are read.
    pub window_tail: f64,
    /// Root mean square error of linear interpolation between texels of a prefiltered table, relative to that of the amplitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interpolation: Option<f64>,
    /// Aliasing of the wavelength nodes: share of the fastest oscillation over the wavelengths that the nodes take for
    /// a slower one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node_alias: Option<f64>,
    /// Width of a lobe in bins of the patch, `σf·L`, if the error depends on it. Above 0.2 lobes overlap and interfere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lobe_bins: Option<f64>,
}

impl ErrorBound {
    /// The bounds of a series under a window with a tail.
    pub(super) fn new(series: &Series, window_radius: Option<u32>, window_tail: f64) -> ErrorBound {
        ErrorBound {
            terms: series.terms(),
            phase_function: series.phase_bound(),
            phase_function_seen: series.seen_error(),
            accepted: series.is_accepted(),
            packing: rounding(series.format, series.terms_sum()),
            window_radius,
            window_tail,
            interpolation: None,
            node_alias: None,
            lobe_bins: None,
        }
    }
}

/// Bounds of a sum over lobes.
#[derive(Clone, Debug, Serialize)]
pub struct LobeBounds {
    /// Maximum number of bins that a pixel examines in any direction, each evaluated at most twice: the static bound of
    /// the shader's loops.
    pub candidates: u32,
    /// Maximum `σf·L`: width of the window's spectrum, divided by the distance between bins.
    pub overlap: f64,
    /// Maximum overlap at which lobes count as separate. `None` where intensities add, which is exact at any overlap.
    pub overlap_limit: Option<f64>,
}

/// Half a unit in the last place of every term at its maximum, for a sum of these maxima.
pub(super) fn rounding(format: TableFormat, terms_sum: f64) -> f64 {
    terms_sum
        * match format {
            TableFormat::F32 => 2.0_f64.powi(-24),
            TableFormat::F16 => 2.0_f64.powi(-11),
            TableFormat::Rgb9e5 => 2.0_f64.powi(-10),
        }
}

/// Share of the light that `pq` loses by interpolating from `taps` bins: `1 - Q ∫ A(t)² Σ D(t - k)² dt` over one bin of
/// `t` and summed over the bins that are kept, on both axes. The sum `Σ D²` over all bins is 1.
pub fn replica_tail(periods: [u32; 2], taps: [u32; 2], pixels: [u32; 2]) -> f64 {
    const STEPS: i32 = 16;
    let kept = |axis: usize| {
        let (q, taps, count) = (periods[axis], taps[axis], f64::from(pixels[axis]));
        let kernel = |t: f64| sinc(t) / sinc(t / count);
        // midpoint rule, fine enough for the lobes of Q replicas
        let steps = STEPS * q.min(1000) as i32;
        let (mut all, mut kept) = (0.0, 0.0);
        for i in 0..steps {
            let t = (f64::from(i) + 0.5) / f64::from(steps) - 0.5;
            let factor = replica_factor(t, q).powi(2);
            let first = (t - 0.5 * f64::from(taps - 1) + 0.5).floor();
            let sum: f64 = (0..taps).map(|k| kernel(t - first - f64::from(k)).powi(2)).sum();
            all += factor;
            kept += factor * sum.min(1.0);
        }
        kept / all
    };
    1.0 - kept(0) * kept(1)
}

/// Maximum share of the window's energy beyond `radius` bins from the nearest one, over all positions between bins and
/// all wavelengths of a range in nm.
pub fn window_tail(
    window: impl Into<Window>,
    range_nm: [f64; 2],
    patch_um: [f64; 2],
    radius: u32,
) -> f64 {
    let window = window.into();
    let kept = |size_um: f64| {
        range_nm
            .iter()
            .map(|&nm| {
                let sigma_bins = size_um / (TAU * optics::window_sigma_um(window, nm));
                (0..=10)
                    .map(|i| kept_on_axis(sigma_bins, f64::from(i) * 0.05, radius))
                    .fold(1.0, f64::min)
            })
            .fold(1.0, f64::min)
    };
    1.0 - kept(patch_um[0]) * kept(patch_um[1])
}

fn kept_on_axis(sigma_bins: f64, offset: f64, radius: u32) -> f64 {
    let radius = i64::from(radius);
    let far = radius + 2 + (8.0 * sigma_bins).ceil() as i64;
    // relative to the nearest bin, so that weights of a spectrum much narrower than a bin do not underflow
    let energy = |bin: i64| {
        (-((bin as f64 - offset).powi(2) - offset * offset) / (sigma_bins * sigma_bins)).exp()
    };
    let sum = |reach: i64| (-reach..=reach).map(energy).sum::<f64>();
    sum(radius) / sum(far)
}
