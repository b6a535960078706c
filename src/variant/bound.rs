//! A-priori bounds of approximations, for every direction.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::field::replicas::{replica_factor, sinc};
use crate::optics;
use crate::plan::{TableFormat, Window};
use crate::tables::Series;

/// Share of the window's energy that `window_radius = "auto"` may leave out.
pub const AUTO_TAIL: f64 = 1e-4;
/// The same of `pq`, whose periodic sinc falls off like the inverse of the distance.
pub const AUTO_TAIL_PQ: f64 = 1e-2;
/// Above this `σf·L`, in bins, neighbouring lobes overlap, and amplitudes of neighbouring bins interfere.
pub const ISOLATED: f64 = 0.2;

/// A-priori bounds, for every direction.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorBound {
    /// Number of terms.
    pub terms: u32,
    /// Greatest error of the phase function after the series is cut.
    pub phase_function: f64,
    /// Greatest error of a bin's amplitude by the rounding of its terms to the table's format.
    pub packing: f64,
    /// Bins to each side of the nearest one; none where a corridor of four standard deviations takes their place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window_radius: Option<u32>,
    /// Share of the coherence window's energy, or of the light that the replicas send between their bins, beyond them.
    pub window_tail: f64,
    /// What linear interpolation leaves of the amplitude between texels that have the window in them, root of the mean square.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interpolation: Option<f64>,
    /// Share of what oscillates fastest along the wavelengths that their nodes take for something slower.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node_alias: Option<f64>,
    /// Width of a lobe in bins of the patch, `σf·L`, of forms for which it makes a difference: above 0.2 lobes overlap and
    /// interfere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lobe_bins: Option<f64>,
}

impl ErrorBound {
    /// Of a series under a window with a tail.
    pub(super) fn new(series: &Series, window_radius: Option<u32>, window_tail: f64) -> ErrorBound {
        ErrorBound {
            terms: series.terms(),
            phase_function: series.phase_bound(),
            packing: packing(series),
            window_radius,
            window_tail,
            interpolation: None,
            node_alias: None,
            lobe_bins: None,
        }
    }
}

/// What bounds a sum over lobes.
#[derive(Clone, Debug, Serialize)]
pub struct LobeBounds {
    /// Greatest number of bins that a pixel looks at, each of which counts at most twice: the static bound of the shader's loops,
    /// whatever the direction.
    pub candidates: u32,
    /// `σf·L`, width of the window's spectrum over the distance of bins, at its greatest.
    pub overlap: f64,
    /// Up to which overlap the sum is that of amplitudes; none where intensities add, which is exact at any.
    pub overlap_limit: Option<f64>,
}

/// Half a unit in the last place of every term at its largest.
fn packing(series: &Series) -> f64 {
    series.terms_sum()
        * match series.format {
            TableFormat::F32 => 2.0_f64.powi(-24),
            TableFormat::F16 => 2.0_f64.powi(-11),
            TableFormat::Rgb9e5 => 2.0_f64.powi(-10),
        }
}

/// Share of the light that `pq` loses by interpolating from `taps` bins: `1 - Q ∫ A(t)² Σ D(t - k)² dt` over a bin and over
/// the bins kept, on both axes. All bins together have `Σ D² = 1`.
pub fn replica_tail(periods: [u32; 2], taps: [u32; 2], pixels: [u32; 2]) -> f64 {
    const STEPS: i32 = 16;
    let kept = |axis: usize| {
        let (q, taps, count) = (periods[axis], taps[axis], f64::from(pixels[axis]));
        let kernel = |t: f64| sinc(t) / sinc(t / count);
        // midpoints, fine enough for the lobes of Q replicas
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

/// Greatest share of the window's energy beyond `radius` bins of the nearest one, over all places between bins and the
/// wavelengths of a range, nm.
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
    // relative to the nearest bin, so that a window much narrower than a bin does not underflow
    let energy = |bin: i64| {
        (-((bin as f64 - offset).powi(2) - offset * offset) / (sigma_bins * sigma_bins)).exp()
    };
    let sum = |reach: i64| (-reach..=reach).map(energy).sum::<f64>();
    sum(radius) / sum(far)
}
