//! The coherence window in comparison with the patch.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::optics::{REFERENCE_NM, window_sigma_um};
use crate::plan::{Coherence, Optics};
use crate::surface::facts::Facts;

/// Maximum `σf·L` at which the lobes of neighbouring orders count as separate: half way between them the amplitude is
/// below 0.05.
const APART: f64 = 0.2;

/// Width and overlap of the lobes of orders. Pairs are along x and y.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Window {
    /// The plan's `coherence`: whether amplitudes or intensities of orders add.
    pub coherence: Coherence,
    /// Coherence length ℓc, µm, at 550 nm.
    pub coherence_um: f64,
    /// Standard deviation of a lobe, `σf = 1/(2π σs)`, cycles per µm.
    pub sigma_cpum: f64,
    /// The same in bins, `σf·L`.
    pub sigma_bins: [f64; 2],
    /// Amplitude of an order's lobe half way to the next order, relative to its peak.
    pub half_way: [f64; 2],
    /// Number of patches of the tiling within the coherence length.
    pub patches: [f64; 2],
    /// Whether lobes of neighbouring orders overlap.
    pub overlap: [bool; 2],
    /// The consequences, as sentences.
    pub meaning: Vec<String>,
}

impl Window {
    /// Compares the window with a patch. A synthetic patch is one period of an infinite surface.
    pub fn new(optics: &Optics, facts: &Facts, is_synthetic: bool) -> Window {
        let sigma_cpum = 1.0 / (TAU * window_sigma_um(optics, REFERENCE_NM));
        let sigma_bins = facts.size_um.map(|size_um| sigma_cpum * size_um);
        let overlap = sigma_bins.map(|bins| bins >= APART);
        let is_whole = is_synthetic || facts.joins == [true; 2];
        let meaning = meaning(optics, facts, overlap.contains(&true), is_whole);
        Window {
            coherence: optics.coherence,
            coherence_um: optics.coherence_um,
            sigma_cpum,
            sigma_bins,
            half_way: sigma_bins.map(|bins| (-0.125 / (bins * bins)).exp()),
            patches: facts.size_um.map(|size_um| optics.coherence_um / size_um),
            overlap,
            meaning,
        }
    }
}

fn meaning(optics: &Optics, facts: &Facts, overlap: bool, is_whole: bool) -> Vec<String> {
    let mut lines = Vec::new();
    let text = if overlap {
        "orders overlap and interfere: `single` shows one place of the surface, with speckle; `ensemble` shows the mean over all places"
    } else {
        "orders do not overlap: `single` and `ensemble` give the same colours"
    };
    lines.push(text.to_owned());
    if !is_whole {
        let size_um = facts.size_um[0].max(facts.size_um[1]);
        if overlap {
            lines.push("the patch does not join itself: with `ensemble` its seam adds a streak, unless the scan is cropped to about a period or tapered".to_owned());
        } else {
            lines.push(format!(
                "the patch does not join itself, and the window spans {:.0} repetitions of it: sharp orders {:.3} cycles per µm apart come from the tiling, not from the surface; to avoid them, use a larger scan, or `coherence_um` of at most {:.1}",
                optics.coherence_um / size_um,
                1.0 / size_um,
                // the window of four standard deviations then spans the patch once
                size_um
            ));
        }
    }
    lines
}
