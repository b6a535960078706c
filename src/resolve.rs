//! What a variant becomes on a surface: counts that were left to the tool, sizes, static cost.

mod bake;
mod corridor;
mod cost;
mod period;
mod prefilter;
mod scale;

use std::f64::consts::{PI, TAU};

use crate::basis::Expansion;
use crate::error::{Error, Result, Stage};
use crate::height::HeightField;
use crate::optics;
use crate::plan::{Auto, Basis, Coherence, Mode, Packing, Reconstruction, TableFormat, Variant};
use crate::spectrum::Spectrum;
use crate::tables::Scale;
use crate::terms::Grid;
use crate::transform::Bins;

pub use bake::{Axes, octant};
pub use corridor::{BROADEST, Corridor, LEAST_SQUARED, Lobes, OUTER_NODES, REACH_SIGMAS};
pub use cost::Cost;
pub use prefilter::{GRID_ERROR, NODE_ERROR, NODE_LEVELS, grid_error, node_level};

/// A variant with every number known. What a mode does not read has a neutral value.
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
    /// Pixels along x and y.
    pub pixels: [u32; 2],
    /// Replicas along x and y, of `pq`.
    pub periods: [u32; 2],
    /// Bins along x and y that `pq` interpolates from: `2·radius + 1`, and not more than there are pixels.
    pub taps: [u32; 2],
    /// Bounds of the loops of `adaptive`.
    pub corridor: Corridor,
    /// Period as a vector, µm, of `gems`.
    pub grating_um: [f64; 2],
    /// Grid of a prefiltered table, whose bins are its own.
    pub grid: Option<Grid>,
    /// Wavelength nodes at every level of `|(u, v)|`, of `adaptive` on a prefiltered table.
    pub node_counts: Vec<u32>,
    /// Columns of the table of coefficients; 0 without one.
    pub coefficient_count: usize,
    /// Axes of the table of colours, of `baked`.
    pub axes: Axes,
    /// Scales of the terms.
    pub scale: Scale,
    /// Static cost.
    pub cost: Cost,
}

impl Resolved {
    /// Bound of the phase function's error, that of coefficients between their nodes included.
    pub fn phase_bound(&self) -> f64 {
        let nearest = match (self.grid, self.coefficient_count) {
            // half a step at the greatest height
            (Some(_), count) if count > 0 => {
                0.5 * self.expansion.z_max * self.expansion.reach_um / (count - 1) as f64
            }
            _ => 0.0,
        };
        self.expansion.bound() + nearest
    }
}

/// Share of the window's energy that `window_radius = "auto"` may leave out.
pub const AUTO_TAIL: f64 = 1e-4;
/// The same of `pq`, whose periodic sinc falls off like the inverse of the distance.
pub const AUTO_TAIL_PQ: f64 = 1e-2;
/// Above this `σf·L`, in bins, neighbouring lobes overlap, and amplitudes of neighbouring bins interfere.
pub const ISOLATED: f64 = 0.2;

/// Chooses what was left to the tool. Pure arithmetic on the surface's size and height range; only `gems` looks at the
/// heights themselves. An error is a combination of mode and surface that has no meaning, with the reason.
pub fn resolve(variant: &Variant, height: &HeightField) -> Result<Resolved> {
    let patch_um = [height.size_x_um(), height.size_y_um()];
    let pixels = [height.columns() as u32, height.rows() as u32];
    let min_nm = variant.wavelengths.min_nm;
    let lobes = Lobes::new(variant, patch_um);
    let grating_um = match variant.mode {
        Mode::Adaptive if variant.reconstruction == Reconstruction::Window => {
            check_isolated(variant, &lobes).map(|()| [0.0; 2])?
        }
        Mode::Gems => period::strongest_um(height).ok_or_else(|| {
            Error::new(Stage::Compute, &variant.name, "a flat surface has no period")
                .remedy("gems is for gratings")
        })?,
        Mode::Full | Mode::Pq | Mode::Adaptive | Mode::Baked => [0.0; 2],
    };
    let expansion = match variant.terms {
        // the table of colours has terms of its own
        _ if variant.mode == Mode::Baked => Expansion::new(variant.basis, 1, height, min_nm),
        // with so many terms, the best colours
        Auto::Value(terms) if variant.basis == Basis::Optimal => {
            let best_nm =
                Spectrum::new(&variant.optics.illuminant)?.faint_below_nm(&variant.wavelengths);
            Expansion::best_from(best_nm, variant.basis, terms, height, min_nm)
        }
        Auto::Value(terms) => Expansion::new(variant.basis, terms, height, min_nm),
        Auto::Auto => {
            Expansion::new(variant.basis, 1, height, min_nm).with_error(variant.term_error)
        }
    };
    check_reached(variant, &expansion)?;
    let periods = match (variant.mode, variant.periods) {
        (Mode::Pq, Some(periods)) => periods,
        (Mode::Pq, None) => patch_um.map(|size_um| {
            (variant.optics.coherence_um / size_um).round().clamp(1.0, MOST_PERIODS) as u32
        }),
        _ => [1; 2],
    };
    let tail = |radius: u32| match variant.mode {
        Mode::Pq => replica_tail(periods, taps(radius, pixels), pixels) / AUTO_TAIL_PQ,
        _ => window_tail(variant, patch_um, radius) / AUTO_TAIL,
    };
    let window_radius = match variant.window_radius {
        Auto::Value(radius) => radius,
        // the kernel of `pq` is no kernel without a neighbour
        Auto::Auto => (u32::from(variant.mode == Mode::Pq)..=64)
            .find(|&radius| tail(radius) <= 1.0)
            .unwrap_or(64),
    };
    let (low_um, high_um) = height.range_um();
    let corridor = lobes.corridor(high_um - low_um);
    let grid = prefilter::grid(variant, height)?;
    let margin = match variant.mode {
        // the texel on the other side
        _ if grid.is_some() => [1; 2],
        Mode::Adaptive => corridor.margin.map(|m| m as usize),
        // one bin more, because a 32-bit place may round the other way
        _ => [window_radius as usize + 1; 2],
    };
    let size_um = grid.map_or(patch_um, |grid| grid.size_um);
    // |u| and |v| reach 2
    let [x, y] = margin.map(|m| Bins::reachable(size_um[0], size_um[1], 2.0 / (min_nm * 1e-3), m));
    let bins = Bins { r_max: x.r_max, s_max: y.s_max };
    let layers = expansion.terms.div_ceil(match variant.packing {
        Packing::Paired => 2,
        Packing::Single => 1,
    });
    let scale = match variant.table {
        // colours have a scale of their own
        TableFormat::F32 | TableFormat::Rgb9e5 => Scale::NONE,
        TableFormat::F16 if variant.mode == Mode::Baked => Scale::NONE,
        TableFormat::F16 => scale::scale(&expansion),
    };
    let coefficient_count = match grid {
        Some(_) if expansion.is_tabulated() => NEAREST_COEFFICIENTS,
        _ => expansion.nodes(),
    };
    let mut resolved = Resolved {
        expansion,
        window_radius,
        bins,
        layers,
        patch_um,
        pixels,
        periods,
        taps: taps(window_radius, pixels),
        corridor,
        grating_um,
        grid,
        node_counts: prefilter::node_counts(variant, height),
        coefficient_count,
        axes: match variant.mode {
            Mode::Baked => Axes::new(variant, high_um - low_um),
            _ => Axes::default(),
        },
        scale,
        cost: Cost::default(),
    };
    resolved.cost = cost::cost(variant, &resolved, &lobes);
    Ok(resolved)
}

/// Columns of coefficients that are taken from the nearest one: half a step of `z` turns the phase of a height of 0.2 µm by
/// 1.6e-3. It is the width of a texture that every profile allows.
const NEAREST_COEFFICIENTS: usize = 2048;

/// Most replicas along an axis.
const MOST_PERIODS: f64 = 10000.0;

/// Refuses an error that the interpolated coefficients of a basis cannot keep.
fn check_reached(variant: &Variant, expansion: &Expansion) -> Result<()> {
    let (bound, wanted) = (expansion.bound(), variant.term_error);
    if variant.terms != Auto::Auto || !expansion.is_tabulated() || bound <= wanted {
        return Ok(());
    }
    let cause = format!("no number of terms keeps `term_error = {wanted:e}`: {bound:.1e} is left");
    Err(Error::new(Stage::Compute, &variant.name, cause)
        .remedy("use a larger `term_error`, or basis = \"taylor\""))
}

/// Refuses `adaptive` where amplitudes of neighbouring bins interfere: it adds intensities.
fn check_isolated(variant: &Variant, lobes: &Lobes) -> Result<()> {
    let [x, y] = lobes.sigma_bins();
    let widest = x.max(y);
    if variant.optics.coherence == Coherence::Ensemble || widest <= ISOLATED {
        return Ok(());
    }
    let cause =
        format!("neighbouring lobes overlap and interfere: σf·L = {widest:.2}, above {ISOLATED}");
    Err(Error::new(Stage::Compute, &variant.name, cause).remedy(
        "use reconstruction = \"prefiltered\", coherence = \"ensemble\", or mode = \"full\"",
    ))
}

fn taps(radius: u32, pixels: [u32; 2]) -> [u32; 2] {
    pixels.map(|count| count.min(2 * radius + 1))
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
            let factor = crate::replicas::replica_factor(t, q).powi(2);
            let first = (t - 0.5 * f64::from(taps - 1) + 0.5).floor();
            let sum: f64 = (0..taps).map(|k| kernel(t - first - f64::from(k)).powi(2)).sum();
            all += factor;
            kept += factor * sum.min(1.0);
        }
        kept / all
    };
    1.0 - kept(0) * kept(1)
}

fn sinc(t: f64) -> f64 {
    if t == 0.0 { 1.0 } else { (PI * t).sin() / (PI * t) }
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
