//! What a variant becomes on a surface: counts that were left to the tool, sizes, static cost.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::basis::Expansion;
use crate::height::HeightField;
use crate::optics;
use crate::plan::{Auto, Packing, Variant};
use crate::transform::Bins;

/// A variant with every number known.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// Basis laid on the surface; holds the number of terms.
    pub expansion: Expansion,
    /// Bins to each side of the nearest one.
    pub window_radius: u32,
    /// Bins that can be reached, the table's size.
    pub bins: Bins,
    /// Layers of the term table.
    pub layers: u32,
    /// Patch size `(Lx, Ly)`, µm.
    pub patch_um: [f64; 2],
    /// Static cost.
    pub cost: Cost,
}

/// What one lit pixel costs, whatever the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Cost {
    /// Evaluations of the amplitude: wavelength nodes.
    pub evaluations: u64,
    /// Texels read from the term table.
    pub term_fetches: u64,
    /// All texels read.
    pub fetches: u64,
    /// Bytes of all tables.
    pub table_bytes: u64,
}

/// Share of the window's energy that `window_radius = "auto"` may leave out.
pub const AUTO_TAIL: f64 = 1e-4;

/// Chooses what was left to the tool. Pure arithmetic on the surface's size and height range; no transform.
pub fn resolve(variant: &Variant, height: &HeightField) -> Resolved {
    let patch_um = [height.size_x_um(), height.size_y_um()];
    let min_nm = variant.wavelengths.min_nm;
    let expansion = match variant.terms {
        Auto::Value(terms) => Expansion::new(variant.basis, terms, height, min_nm),
        Auto::Auto => {
            Expansion::new(variant.basis, 1, height, min_nm).with_error(variant.term_error)
        }
    };
    let window_radius = match variant.window_radius {
        Auto::Value(radius) => radius,
        Auto::Auto => {
            (0..=64).find(|&r| window_tail(variant, patch_um, r) <= AUTO_TAIL).unwrap_or(64)
        }
    };
    // |u| and |v| reach 2; one bin more, because a 32-bit place may round the other way
    let bins = Bins::reachable(
        patch_um[0],
        patch_um[1],
        2.0 / (min_nm * 1e-3),
        window_radius as usize + 1,
    );
    let (per_texel, channels) = match variant.packing {
        Packing::Paired => (2, 4),
        Packing::Single => (1, 2),
    };
    let layers = expansion.terms.div_ceil(per_texel);
    let evaluations = variant.wavelengths.nodes_nm().len() as u64;
    let taps = u64::from(2 * window_radius + 1).pow(2);
    let term_fetches = evaluations * taps * u64::from(layers);
    let table_bytes = 4 * (bins.len() as u64 * u64::from(layers) * channels + 2 * 4 * evaluations);
    let cost = Cost { evaluations, term_fetches, fetches: term_fetches + evaluations, table_bytes };
    Resolved { expansion, window_radius, bins, layers, patch_um, cost }
}

/// Greatest share of the window's energy beyond `radius` bins of the nearest one, over all places between bins and the
/// variant's wavelengths.
pub fn window_tail(variant: &Variant, patch_um: [f64; 2], radius: u32) -> f64 {
    let ends = [variant.wavelengths.min_nm, variant.wavelengths.max_nm];
    let kept = |size_um: f64| {
        ends.iter()
            .map(|&nm| {
                let sigma_bins = size_um / (TAU * optics::window_sigma_um(&variant.optics, nm));
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
