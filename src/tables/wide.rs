//! Sizes of the tables of colours with wider lobes, and their places in one texture.
//!
//! A lobe whose width is a number of direction cosines, the same at all wavelengths, is a coherence length that is
//! proportional to the wavelength. Widths add in variance, so a spread `σ` makes of the coherence length `ℓc` one of
//! `ℓc/sqrt(1 + σ²/σ0²)`, where `σ0 = √2·550 nm/(π ℓc)` is the standard deviation of the narrowest lobe. Level k has the
//! coherence length `ℓc/step^k`. Its colours are those of lobes with the peak 1, as in the narrowest table, so that they
//! fit into the same numbers. The shader multiplies them by `step^(-2k)`, which keeps the energy.
//!
//! All levels stand side by side in one texture: a texture for each would take most of the 16 units of WebGL2, whose
//! shaders can choose between textures only by branches. The narrowest table keeps a texture of its own, the one of
//! variants without levels. The sizes of a level are in a texel, since shaders cannot choose among constants, either.

use serde::Serialize;

use crate::optics::REFERENCE_NM;
use crate::plan::{TableFormat, Window};

use super::axes::{MAX_LAYERS, finest};
use super::{Aim, BakedAxes, colour_format};

/// A table of colours with wider lobes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WideLevel {
    /// The window whose lobes are that wide.
    pub window: Window,
    /// Its sizes. Pages stand below one another.
    pub axes: BakedAxes,
    /// Column and row of its first texel.
    pub place: [u32; 2],
}

/// All of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WideAxes {
    /// From narrow lobes to wide ones. All have as many layers.
    pub levels: Vec<WideLevel>,
}

/// Largest number of columns and rows that every profile allows.
const MAX_SIZE: u32 = 2048;

/// Standard deviation of a lobe in direction cosines, the same on both axes, for a coherence length that is proportional
/// to the wavelength.
pub fn lobe_sigma(window: Window) -> f64 {
    std::f64::consts::SQRT_2 * REFERENCE_NM * 1e-3 / (std::f64::consts::PI * window.coherence_um)
}

impl WideAxes {
    /// Chooses sizes for `count` levels. They have the error to aim at, unless together they are larger than the maximum
    /// size. `with_matter`: as [`BakedAxes::with_matter`].
    pub fn new(
        (window, step): (Window, f64),
        count: u32,
        (format, aim): (TableFormat, Aim),
        height_um: f64,
        with_matter: impl Fn(BakedAxes) -> BakedAxes,
    ) -> WideAxes {
        let sized = |fineness: f64| {
            let mut levels = Vec::new();
            let mut coherence_um = window.coherence_um;
            for _ in 0..count {
                coherence_um /= step;
                let window = Window { coherence_um, ..window };
                let axes = with_matter(BakedAxes::sized(window, height_um, fineness));
                levels.push(WideLevel { window, axes, place: [0; 2] });
            }
            placed(&levels)
        };
        let texel = colour_format(format).texel_bytes() as f64;
        let fits = |wide: &WideAxes| {
            let [width, height] = wide.size();
            wide.texels() as f64 * texel <= aim.mib * f64::from(1 << 20)
                && width <= MAX_SIZE
                && height <= MAX_SIZE
                && wide.layers() <= MAX_LAYERS
        };
        finest(aim.error, sized, fits)
    }

    /// Number of columns and rows of the texture.
    pub fn size(&self) -> [u32; 2] {
        let end = |axis: usize| {
            let ends = self.levels.iter().map(|level| level.place[axis] + level.size()[axis]);
            ends.max().unwrap_or(1)
        };
        [end(0), end(1)]
    }

    /// Number of layers.
    pub fn layers(&self) -> u32 {
        self.levels.iter().map(|level| level.axes.levels).max().unwrap_or(1)
    }

    /// Number of texels of the texture, unused ones among them.
    pub fn texels(&self) -> u64 {
        let [width, height] = self.size();
        u64::from(width) * u64::from(height) * u64::from(self.layers())
    }
}

impl WideLevel {
    /// Number of columns and rows that it covers.
    pub fn size(&self) -> [u32; 2] {
        [self.axes.page_columns() + 1, self.axes.pages * self.axes.rows]
    }

    /// What a shader needs to know: its first column plus [`PACKED`] times its number of rows; its first row; columns of a
    /// page, without the repeated one, plus [`PACKED`] times the number of pages; its stretch.
    pub fn texel(&self) -> [f64; 4] {
        let BakedAxes { rows, pages, stretch, .. } = self.axes;
        let packed = |low: u32, high: u32| f64::from(low) + f64::from(PACKED) * f64::from(high);
        let columns = packed(self.axes.page_columns(), pages);
        [packed(self.place[0], rows), f64::from(self.place[1]), columns, stretch]
    }
}

/// Factor of the second of two numbers in one. Both are smaller than this, so a 32-bit float holds their sum.
pub const PACKED: u32 = 4096;

/// Places levels on shelves from left to right. The width of the texture is the one with the fewest texels.
fn placed(levels: &[WideLevel]) -> WideAxes {
    let widest = levels.iter().map(|level| level.size()[0]).max().unwrap_or(1);
    let sum: u32 = levels.iter().map(|level| level.size()[0]).sum();
    let widths = (0..levels.len()).flat_map(|first| {
        let sizes = levels[first..].iter().map(|level| level.size()[0]);
        sizes.scan(0, |width, size| {
            *width += size;
            Some(*width)
        })
    });
    let widths = widths.filter(|width| (widest..=MAX_SIZE.max(widest)).contains(width));
    let best = widths.map(|width| shelved(levels, width)).min_by_key(WideAxes::texels);
    best.unwrap_or_else(|| shelved(levels, sum))
}

fn shelved(levels: &[WideLevel], width: u32) -> WideAxes {
    let (mut corner, mut shelf) = ([0, 0], 0);
    let place = |level: &WideLevel| {
        let [columns, rows] = level.size();
        if corner[0] + columns > width {
            corner = [0, corner[1] + shelf];
            shelf = 0;
        }
        let place = corner;
        corner[0] += columns;
        shelf = shelf.max(rows);
        WideLevel { place, ..*level }
    };
    WideAxes { levels: levels.iter().map(place).collect() }
}
