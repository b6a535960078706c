//! Common parts of forms on a table that contains the window: the grid of the table, and the wavelength nodes.

use std::f64::consts::{PI, SQRT_2, TAU};

use crate::error::{Error, Result};
use crate::optics::{self, Matter};
use crate::plan::Variant;
use crate::surface::HeightField;
use crate::tables::terms::Grid;
use crate::tables::{NODE_LEVELS, Reach, Series};

use super::{ErrorBound, lay};

/// Promised 95th percentile of CIEDE2000, if the wavelength steps are fine enough.
pub(super) const MODEL_P95: f64 = 1.5;

/// Target error of linear interpolation in the grid: root mean square, relative to that of the amplitude.
pub const GRID_ERROR: f64 = 0.008;
/// Maximum number of samples of the transform along an axis. With this number on both axes, the samples take a gigabyte.
const MAX_SAMPLES: usize = 8192;

/// Maximum aliasing of wavelength nodes: share of the fastest oscillation along 1/λ that the nodes take for a slower one.
///
/// Along `f = (u, v)/λ` the amplitude is a sum of waves in 1/λ whose rate is a path difference: `(u, v)·x` under the
/// window and `w h`. The differences of two rates have the Gaussian distribution `exp(-τ²/4σ²)`, `σ = |(u, v)| σs`,
/// plus the range of the heights. `n` nodes over a range `T` take the rate `n/T` for 0. At `n/T = pace σ` the
/// distribution has fallen to this value.
pub const NODE_ERROR: f64 = 0.07;
/// Rate that the colour weights add, µm. Their narrowest lobe, in the blue, is 0.12/µm wide.
const COLOUR_PATH_UM: f64 = 4.5;

/// The terms of a variant on the grid.
pub(super) fn series(variant: &Variant, height: &HeightField, matter: &Matter) -> Result<Series> {
    let grid = grid(variant, height)?;
    let expansion = lay::expansion(variant, height, matter)?;
    let reach = Reach::Prefiltered { coherence_um: variant.optics.coherence_um };
    // one more, for the neighbouring texel
    let bins = lay::bins(grid.size_um, variant.wavelengths.min_nm, [1; 2]);
    let texels = (variant.packing, variant.table);
    Ok(Series::new(expansion, reach, bins, Some(grid), grid.size_um, texels))
}

/// Error bounds of a series on a grid.
pub(super) fn error_bound(series: &Series, patch_um: [f64; 2]) -> Option<ErrorBound> {
    let grid = series.grid.as_ref()?;
    let sizes = patch_um.map(|size_um| size_um / (TAU * grid.sigma_um));
    Some(ErrorBound {
        interpolation: Some(grid_error(grid)),
        lobe_bins: Some(sizes[0].max(sizes[1])),
        ..ErrorBound::new(series, None, beyond(grid))
    })
}

/// Share of the window beyond its grid, which ends at half its size from the middle.
fn beyond(grid: &Grid) -> f64 {
    grid.size_um.map(|size_um| libm::erfc(0.5 * size_um / grid.sigma_um)).iter().sum()
}

/// The grid of a variant on a surface.
fn grid(variant: &Variant, height: &HeightField) -> Result<Grid> {
    let sigma_um = optics::window_sigma_um(&variant.optics, optics::REFERENCE_NM);
    let pitch_um = [height.pitch_x_um(), height.pitch_y_um()];
    let wanted_um = sigma_um * (interpolation() / GRID_ERROR).sqrt();
    let samples = pitch_um.map(|pitch_um| smooth((wanted_um / pitch_um).ceil() as usize));
    if let Some(max) = samples.iter().max().filter(|max| **max > MAX_SAMPLES) {
        let cause = format!(
            "the window of coherence_um = {} needs {max} samples on an axis, above the limit of {MAX_SAMPLES}",
            variant.optics.coherence_um
        );
        let otherwise = "use a shorter coherence length, or reconstruction = \"window\"";
        return Err(Error::new(&variant.name, cause).remedy(
            match coarser(variant, height, wanted_um) {
                Some(pitch) => format!("{pitch}; or {otherwise}"),
                None => otherwise.to_owned(),
            },
        ));
    }
    let size_um = [0, 1].map(|axis| samples[axis] as f64 * pitch_um[axis]);
    Ok(Grid { samples, size_um, sigma_um })
}

/// What a coarser scan would do: a pitch at which the window needs fewer samples and which still resolves the shortest
/// wavelength. `None` if there is no such pitch.
fn coarser(variant: &Variant, height: &HeightField, wanted_um: f64) -> Option<String> {
    // resampling keeps the size of the patch, so its pitch is the size divided by a whole number
    let axis = |size_um: f64| {
        let pixels = (size_um * MAX_SAMPLES as f64 / wanted_um).floor();
        (pixels >= 1.0).then(|| size_um / pixels)
    };
    let pitch_um = axis(height.size_x_um())?.max(axis(height.size_y_um())?);
    // four digits after the point, upwards
    let pitch_um = (pitch_um * 1e4).ceil() / 1e4;
    let limit_um = variant.wavelengths.min_nm / 4000.0;
    let samples = smooth((wanted_um / pitch_um).ceil() as usize);
    (pitch_um <= limit_um).then(|| {
        format!(
            "the scan, with a pitch of {:.4} µm, is finer than the shortest wavelength needs ({limit_um:.4} µm): \
             resample_um = {pitch_um} in its surface makes {samples} samples of them",
            height.pitch_x_um().min(height.pitch_y_um())
        )
    })
}

/// Root mean square error of a grid's interpolation, relative to that of the amplitude, to first order in the grid's spacing.
pub fn grid_error(grid: &Grid) -> f64 {
    let [x, y] = grid.size_um.map(|size_um| (grid.sigma_um / size_um).powi(2));
    interpolation() * (0.5 * (x * x + y * y)).sqrt()
}

/// Number of wavelength nodes at every level of `|(u, v)|`, for the upper end of the level. For a single wavelength,
/// one level with one node.
pub(super) fn node_counts(variant: &Variant, height: &HeightField, matter: &Matter) -> Vec<u32> {
    let waves = &variant.wavelengths;
    if waves.max_nm <= waves.min_nm {
        return vec![1];
    }
    let range = 1e3 / waves.min_nm - 1e3 / waves.max_nm;
    let sigma_um = optics::window_sigma_um(&variant.optics, optics::REFERENCE_NM);
    let pace = 2.0 * (-NODE_ERROR.ln()).sqrt();
    let (low_um, high_um) = height.range_um();
    let detail_um = matter.detail_um(high_um - low_um);
    let count = |level: u32| {
        let uv = 2.0 * f64::from(level + 1) / f64::from(NODE_LEVELS);
        let path_um = pace * (uv * sigma_um + detail_um) + COLOUR_PATH_UM;
        (range * path_um).ceil().max(1.0) as u32
    };
    (0..NODE_LEVELS).map(count).collect()
}

/// The level of a direction, `uv = |(u, v)|`.
pub fn node_level(uv: f64) -> u32 {
    (uv * 0.5 * f64::from(NODE_LEVELS)).clamp(0.0, f64::from(NODE_LEVELS - 1)) as u32
}

/// At `x` from the `m`-th period, the image of the window is `(x/(size m))²` of the window. With `⟨x⁴⟩ = 3/4 σ⁴` under
/// the squared window and `Σ 1/m⁴ = π⁴/45` over both signs, on both axes, the root mean square error is this number
/// times `(σ/size)²`.
fn interpolation() -> f64 {
    (0.75 * PI.powi(4) / 45.0).sqrt() * SQRT_2
}

/// The next whole number without prime factors above 7, for which transforms are fast.
fn smooth(min: usize) -> usize {
    let is_smooth = |n: &usize| {
        let rest = [2, 3, 5, 7].iter().fold(*n, |mut n, p| {
            while n % p == 0 {
                n /= p;
            }
            n
        });
        rest == 1
    };
    (min.max(1)..).find(is_smooth).unwrap_or(min)
}
