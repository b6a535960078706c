//! Axes of a table of colours over `(u, v, w)`.
//!
//! * **Columns**: the angle of `(u, v)`, measured by [`octant`], a cheap replacement for the arc tangent. The number of
//!   columns is a multiple of eight, so the axes and their bisectors lie on columns. A full turn that is wider than a
//!   texture is divided into pages.
//! * **Rows**: `asinh(s·|(u, v)|)`: equal steps near the mirror direction, equal ratios away from it, since the
//!   integral over wavelengths smears a lobe at `λ f` in proportion to the radius.
//! * **Layers**: `(w² - w0²)/(4 - |(u, v)|²)`, or its square root for a metal in air, which is always from 0 to 1. The square makes layers denser where
//!   directions are steep and the phase `2πwh/λ` is large. `w0` is 0 in air. Under a cover of index n, `w` stands for
//!   `n w'`, and `w0² = 4(n² - 1)`.

use std::f64::consts::{SQRT_2, TAU};

use serde::Serialize;

use crate::optics::{REFERENCE_NM, window_sigma_um};
use crate::plan::{TableFormat, Window};

use super::colour_format;

/// Factor of colours in their table, unless the reflectance rises: see [`BakedAxes::colour_scale`]. A colour without gain is at most the illuminant's white. This power of two leaves
/// room for sharpening in 16-bit floats and in numbers with a shared exponent, and it keeps dim colours above the
/// smallest numbers of these formats.
const COLOUR_SCALE: f64 = 32768.0;

/// Targets for the size of a table of colours.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Aim {
    /// Error to aim at, as the 95th percentile of CIEDE2000.
    pub error: f64,
    /// Maximum size, MiB. It takes precedence over the error.
    pub mib: f64,
}

/// Sizes of a table of colours.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BakedAxes {
    /// Number of columns of a full turn.
    pub columns: u32,
    /// Number of pages that the turn is divided into. Each ends with the first column of the next.
    pub pages: u32,
    /// Number of rows, from the mirror direction to `|(u, v)| = 2`.
    pub rows: u32,
    /// Number of layers of a page.
    pub levels: u32,
    /// The factor `s`.
    pub stretch: f64,
    /// Rows per unit of `asinh`.
    pub pace: f64,
    /// The least `w²`: 0 without a cover.
    #[serde(skip_serializing_if = "is_zero")]
    pub least_w_squared: f64,
    /// Whether layers are equal steps of `w` in place of `w²`: for a metal in air, whose reflectance changes fast where
    /// `w` is small.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub even_w: bool,
    /// Powers of two by which colours are smaller in the table, since the reflectance rises above that at normal incidence: a
    /// dielectric reflects all light at grazing angles.
    #[serde(skip_serializing_if = "is_none")]
    pub dimmed: u32,
}

fn is_none(count: &u32) -> bool {
    *count == 0
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

impl BakedAxes {
    /// Chooses sizes from the widths of lobes along the axes, the error to aim at, and the maximum size. `height_um`:
    /// range of the heights.
    ///
    /// The intensity of a lobe has the standard deviation `λσf/√2` in `|(u, v)|`, here at 500 nm. Along w the phase
    /// changes by `4πH/λ`. Errors of linear interpolation are proportional to the square of the steps. How they are
    /// divided among the axes was chosen by measurement.
    pub fn new(window: Window, format: TableFormat, aim: Aim, height_um: f64) -> BakedAxes {
        let texel = colour_format(format).texel_bytes() as f64;
        let fits = |axes: &BakedAxes| {
            axes.texels() as f64 * texel <= aim.mib * f64::from(1 << 20)
                && axes.pages * axes.levels <= MAX_LAYERS
                && axes.rows <= MAX_COLUMNS
        };
        finest(aim.error, |fineness| BakedAxes::sized(window, height_um, fineness), fits)
    }

    /// Sizes for the lobes of a window. `fineness`: 1 for [`STANDARD_ERROR`].
    pub(super) fn sized(window: Window, height_um: f64, fineness: f64) -> BakedAxes {
        let sigma_um = window_sigma_um(window, REFERENCE_NM);
        let lobe = WAVELENGTH_UM / (TAU * sigma_um * SQRT_2);
        let turns = 2.0 * height_um / WAVELENGTH_UM;
        let stretch = (1.0 / (LOBE_ROWS * lobe * PACE)).round().max(1.0);
        let columns = fineness * TAU / (LOBE_COLUMNS * lobe);
        let pages = (columns / f64::from(MAX_COLUMNS)).ceil().max(1.0) as u32;
        let page = (columns / f64::from(8 * pages)).ceil().clamp(2.0, 1e6) as u32 * 8;
        let pace = (fineness * PACE).round().max(4.0);
        BakedAxes {
            columns: pages * page.min(MAX_COLUMNS),
            pages,
            rows: (pace * (2.0 * stretch).asinh()).ceil() as u32 + 1,
            levels: (fineness * TURN_LEVELS * turns).ceil() as u32 + 2,
            stretch,
            pace,
            least_w_squared: 0.0,
            even_w: false,
            dimmed: 0,
        }
    }

    /// The same for other matter than a dielectric in air, under a cover if `least_w_squared` is above 0.
    #[must_use]
    ///
    /// `brightest`: the largest reflectance relative to that at normal incidence.
    pub fn with_matter(self, least_w_squared: f64, brightest: f64) -> BakedAxes {
        /// What the scale of colours leaves room for, beside the sharpening.
        const ROOM: f64 = 1.5;
        let dimmed = (brightest / ROOM).log2().ceil().clamp(0.0, 30.0) as u32;
        BakedAxes { least_w_squared, even_w: least_w_squared == 0.0, dimmed, ..self }
    }

    /// Factor of colours in the table.
    pub fn colour_scale(&self) -> f64 {
        COLOUR_SCALE / f64::from(1_u32 << self.dimmed)
    }

    /// Number of texels of the table, including repeated columns.
    pub fn texels(&self) -> u64 {
        u64::from(self.pages * (self.page_columns() + 1))
            * u64::from(self.rows)
            * u64::from(self.levels)
    }

    /// Number of columns of a page, without the repeated one.
    pub fn page_columns(&self) -> u32 {
        self.columns / self.pages
    }

    /// Unit vector of a column.
    pub fn direction(&self, column: u32) -> [f64; 2] {
        let place = 8.0 * f64::from(column) / f64::from(self.columns);
        let index = place.floor();
        let part = place - index;
        let odd = index as i64 % 2 == 1;
        let tangent = tangent(if odd { 1.0 - part } else { part });
        let long = 1.0 / tangent.hypot(1.0);
        let short = tangent * long;
        match index as i64 % 8 {
            0 => [long, short],
            1 => [short, long],
            2 => [-short, long],
            3 => [-long, short],
            4 => [-long, -short],
            5 => [-short, -long],
            6 => [short, -long],
            _ => [long, -short],
        }
    }

    /// `|(u, v)|` of a row.
    pub fn radius(&self, row: u32) -> f64 {
        (f64::from(row) / self.pace).sinh() / self.stretch
    }

    /// `w` of a layer of a page at a radius.
    pub fn w(&self, level: u32, radius: f64) -> f64 {
        let share = f64::from(level) / f64::from(self.levels - 1);
        let share = if self.even_w { share * share } else { share };
        -(self.least_w_squared + share * (4.0 - radius * radius).max(0.0)).sqrt()
    }
}

/// The sizes for an error, or the largest smaller ones that fit.
pub(super) fn finest<T>(error: f64, sized: impl Fn(f64) -> T, fits: impl Fn(&T) -> bool) -> T {
    let mut fineness = (STANDARD_ERROR / error).sqrt();
    let mut axes = sized(fineness);
    while !fits(&axes) && fineness > MIN_FINENESS {
        fineness *= SHRINKING;
        axes = sized(fineness);
    }
    axes
}

/// Position in an octant, 0 to 1, of a tangent from 0 to 1. It is within 0.4 % of the arc tangent's position.
pub fn octant(tangent: f64) -> f64 {
    tangent * (BEND - (BEND - 1.0) * tangent)
}

/// The tangent at a position in an octant, the inverse of [`octant`].
fn tangent(place: f64) -> f64 {
    let rest = BEND * BEND - 4.0 * (BEND - 1.0) * place;
    (BEND - rest.sqrt()) / (2.0 * (BEND - 1.0))
}

/// Wavelength at which sizes are chosen, µm.
const WAVELENGTH_UM: f64 = 0.5;
/// The error for which the following numbers hold.
const STANDARD_ERROR: f64 = 0.5;
/// Distance between columns at `|(u, v)| = 1`, in standard deviations of a lobe.
const LOBE_COLUMNS: f64 = 0.6;
/// Distance between the first rows, in standard deviations of a lobe.
const LOBE_ROWS: f64 = 0.27;
/// Rows per factor of e in the radius. The colour-matching functions are a twentieth of their wavelength wide.
const PACE: f64 = 38.0;
/// Levels per full turn of the phase.
const TURN_LEVELS: f64 = 8.5;
/// Factor by which all axes are repeatedly made coarser until the table is small enough.
const SHRINKING: f64 = 0.98;
/// Minimum fineness. Below it, coarser axes do not make the table smaller.
const MIN_FINENESS: f64 = 1e-3;
/// Maximum number of columns of a page, and of rows: a multiple of eight that, with one column more, fits every profile.
const MAX_COLUMNS: u32 = 2040;
/// Maximum number of layers. Every profile allows it.
pub(super) const MAX_LAYERS: u32 = 256;
/// Slope of [`octant`] at 0.
pub const BEND: f64 = 1.35;
