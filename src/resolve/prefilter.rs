//! Sizes of the form `prefiltered`: the grid of its table, and the wavelength nodes of the mode `adaptive`.

use std::f64::consts::{PI, SQRT_2};

use crate::error::{Error, Result, Stage};
use crate::height::HeightField;
use crate::optics;
use crate::plan::{Mode, Reconstruction, Variant};
use crate::terms::Grid;

/// Error of linear interpolation in the grid, the root of its mean square over that of the amplitude.
pub const GRID_ERROR: f64 = 0.013;
/// Most samples of the transform along an axis: two of them make a gigabyte.
const MOST_SAMPLES: usize = 8192;

/// Levels of `|(u, v)|`, from 0 to 2, each with wavelength nodes of its own.
pub const NODE_LEVELS: u32 = 64;
/// Nodes over the range of wavenumbers for every µm of path that the window's standard deviation and the heights make:
/// what oscillates faster is taken for something slower, `exp(-(NODE_PACE/2)²)` of it.
const NODE_PACE: f64 = 3.2;
/// The same that the colour weights themselves need, µm.
const COLOUR_PATH_UM: f64 = 4.5;

/// The grid of a variant on a surface; `None` where its reconstruction is another.
pub(super) fn grid(variant: &Variant, height: &HeightField) -> Result<Option<Grid>> {
    if !is_prefiltered(variant) {
        return Ok(None);
    }
    let sigma_um = optics::window_sigma_um(&variant.optics, optics::REFERENCE_NM);
    let pitch_um = [height.pitch_x_um(), height.pitch_y_um()];
    let wanted_um = sigma_um * (interpolation() / GRID_ERROR).sqrt();
    let samples = pitch_um.map(|pitch_um| smooth((wanted_um / pitch_um).ceil() as usize));
    if let Some(most) = samples.iter().max().filter(|most| **most > MOST_SAMPLES) {
        let cause = format!(
            "a window of coherence_um = {} takes {most} samples on an axis, above {MOST_SAMPLES}",
            variant.optics.coherence_um
        );
        return Err(Error::new(Stage::Compute, &variant.name, cause)
            .remedy("use a shorter coherence length, or reconstruction = \"window\""));
    }
    let size_um = [0, 1].map(|axis| samples[axis] as f64 * pitch_um[axis]);
    Ok(Some(Grid { samples, size_um, sigma_um }))
}

/// Root mean square of what a grid's interpolation leaves, over that of the amplitude, to first order in its spacing.
pub fn grid_error(grid: &Grid) -> f64 {
    let [x, y] = grid.size_um.map(|size_um| (grid.sigma_um / size_um).powi(2));
    interpolation() * (0.5 * (x * x + y * y)).sqrt()
}

/// Wavelength nodes at every level of `|(u, v)|`, at its upper end; empty where the mode has others.
pub(super) fn node_counts(variant: &Variant, height: &HeightField) -> Vec<u32> {
    let waves = &variant.wavelengths;
    let spread = variant.mode == Mode::Adaptive && waves.max_nm > waves.min_nm;
    if !(is_prefiltered(variant) && spread) {
        return Vec::new();
    }
    let range = 1e3 / waves.min_nm - 1e3 / waves.max_nm;
    let sigma_um = optics::window_sigma_um(&variant.optics, optics::REFERENCE_NM);
    let (low_um, high_um) = height.range_um();
    let count = |level: u32| {
        let uv = 2.0 * f64::from(level + 1) / f64::from(NODE_LEVELS);
        let path_um = NODE_PACE * (uv * sigma_um + high_um - low_um) + COLOUR_PATH_UM;
        (range * path_um).ceil().max(1.0) as u32
    };
    (0..NODE_LEVELS).map(count).collect()
}

/// The level of a direction, `uv = |(u, v)|`.
pub fn node_level(uv: f64) -> u32 {
    (uv * 0.5 * f64::from(NODE_LEVELS)).clamp(0.0, f64::from(NODE_LEVELS - 1)) as u32
}

fn is_prefiltered(variant: &Variant) -> bool {
    variant.reconstruction == Reconstruction::Prefiltered
}

/// Images of the window at `x` from the `m`-th period are `(x/(size m))²` of it: with `⟨x⁴⟩ = 3/4 σ⁴` under the squared
/// window and `Σ 1/m⁴ = π⁴/45` over both signs, on both axes, this times `(σ/size)²` is the root of the mean square.
fn interpolation() -> f64 {
    (0.75 * PI.powi(4) / 45.0).sqrt() * SQRT_2
}

/// The next whole number that has no prime factors above 7, for which transforms are fast.
fn smooth(least: usize) -> usize {
    let is_smooth = |n: &usize| {
        let rest = [2, 3, 5, 7].iter().fold(*n, |mut n, p| {
            while n % p == 0 {
                n /= p;
            }
            n
        });
        rest == 1
    };
    (least.max(1)..).find(is_smooth).unwrap_or(least)
}
