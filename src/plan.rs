//! `plan.toml` as pure data: surfaces, optics, the axes of the variants, targets.

mod axis;
mod data;
mod item;
mod local;
mod material;
mod mode;
mod reads;
mod constraints;
mod number;
mod names;
mod optics;
mod parse;
mod select;
mod surface;
mod target;
mod variant;
mod variants;
mod vocabulary;
mod words;

#[cfg(test)]
mod tests;

use std::fmt;
use std::path::PathBuf;

use serde::{Deserialize, Serialize, Serializer};

pub use data::Data;
pub use local::SurfaceOptics;
pub use material::{Film, METALS, Material, Medium, Obliquity};
pub use mode::Mode;
pub use optics::{Coherence, CoherenceScaling, Colour, Illuminant, Optics, Window};
pub use target::Target;
pub use variant::Variant;
pub use variants::MAX_VARIANTS;
pub use vocabulary::{AxisDoc, Key, axis_docs, vocabulary};

/// TOML texts with the place of every value.
pub(crate) mod toml {
    pub(crate) use super::item::{Item, Source, Table};
}

/// One surface of a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfaceSpec {
    /// `[a-z0-9-]+`, unique in the plan.
    pub name: String,
    /// Where the heights come from.
    pub source: SurfaceSource,
    /// Rotation of the surface about its normal in degrees, counter-clockwise seen from above. It rotates `(u, v)` exactly.
    pub rotate_deg: f64,
    /// Levelling applied to the heights.
    pub level: Level,
    /// Percentage of the heights clipped as outliers at each end.
    pub clip_percent: f64,
    /// Light and material of this surface. They override `[optics]`.
    #[serde(skip_serializing_if = "SurfaceOptics::is_empty")]
    pub optics: SurfaceOptics,
}

/// Where the heights of a surface come from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum SurfaceSource {
    /// Computed from a formula.
    Grating(Grating),
    /// Read from a file.
    File(FileSource),
}

/// A measured height field. What the plan leaves out is taken from the file, if the file states it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FileSource {
    /// Path, already resolved against the plan's folder.
    pub path: PathBuf,
    /// Width of the patch in µm; not together with `pixel_um`.
    pub size_um: Option<f64>,
    /// Pixel pitch along both axes in µm; not together with `size_um` or `size_y_um`.
    pub pixel_um: Option<f64>,
    /// Height of the full grey range of an integer file, µm.
    pub height_um: Option<f64>,
    /// Scale of a float file's numbers, µm per unit.
    pub z_unit_um: Option<f64>,
    /// Length of the patch along y in µm, if pixels are not square.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_y_um: Option<f64>,
    /// Name or number (from 1) of the channel, for files with several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    /// The number that stands for pixels without a height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub void_value: Option<VoidValue>,
    /// Which axis is turned round.
    #[serde(skip_serializing_if = "is_default")]
    pub flip: Flip,
    /// Whose numbers are used where plan and file contradict each other.
    #[serde(skip_serializing_if = "is_default")]
    pub trust: Trust,
    /// Largest pitch after resampling, µm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resample_um: Option<f64>,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// The number of a file that stands for pixels without a height.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum VoidValue {
    /// Pixels with this number are void.
    Number(f64),
    /// All numbers are heights, however unlikely they look. Written `"none"`.
    None,
}

/// Turning the heights of a file round.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Flip {
    /// As in the file.
    #[default]
    None,
    /// The last row becomes the first.
    Rows,
    /// The last column becomes the first.
    Columns,
}

/// Whose numbers are used where plan and file contradict each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Trust {
    /// A contradiction is an error.
    #[default]
    File,
    /// The plan's numbers are used, with a note.
    Plan,
}

/// A synthetic surface. `x` grows with the column. One period (or one patch) tiles the plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum Grating {
    /// `h = 0`.
    Flat {
        /// Width of the patch, µm.
        period_um: f64,
        /// Pixels along the period.
        pixels: usize,
    },
    /// `h = (H/2)(1 + cos 2πx/d)`.
    Sinusoidal {
        /// Period `d`, µm.
        period_um: f64,
        /// Height `H`, µm.
        height_um: f64,
        /// Pixels per period.
        pixels: usize,
    },
    /// `h = H x/d` on `[0, d)`.
    Blazed {
        /// Period `d`, µm.
        period_um: f64,
        /// Height `H`, µm.
        height_um: f64,
        /// Pixels per period.
        pixels: usize,
    },
    /// `h = H` on a share `duty` of the period, 0 elsewhere.
    Lamellar {
        /// Period `d`, µm.
        period_um: f64,
        /// Height `H`, µm.
        height_um: f64,
        /// Pixels per period.
        pixels: usize,
        /// Share of the period that is high, `0 < duty < 1`.
        duty: f64,
    },
    /// Rises to `H` over `apex·d`, then falls.
    Triangle {
        /// Period `d`, µm.
        period_um: f64,
        /// Height `H`, µm.
        height_um: f64,
        /// Pixels per period.
        pixels: usize,
        /// Position of the apex as a share of the period, `0 < apex < 1`.
        apex: f64,
    },
    /// `h(x, y) = hx(x) + hy(y)` of two one-dimensional gratings.
    Crossed {
        /// Grating along x.
        x: Box<Grating>,
        /// Grating along y.
        y: Box<Grating>,
    },
    /// Randomly placed smooth domes (a beetle-like surface).
    Bumps(Rough),
    /// Finger-like denticulations in rows (*Elaphe*-like).
    Fingers(Rough),
    /// Straight rows of pits and ribs (*Xenopeltis*-like).
    Rows(Rough),
}

/// Keys of the random surfaces. Their formulas are in [`crate::surface::synthetic`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rough {
    /// Side of the square patch, µm.
    pub size_um: f64,
    /// Pixels along a side.
    pub pixels: usize,
    /// Mean distance between features along x, µm.
    pub pitch_um: f64,
    /// Peak-to-valley height, µm.
    pub height_um: f64,
    /// Seed of the generator.
    pub seed: u64,
    /// Regularity of the placement, from 0 (as irregular as the kind allows) to 1 (a perfect lattice).
    #[serde(default = "default_regularity")]
    pub regularity: f64,
    /// Distance between features along y, µm. Defaults: `2.6·pitch_um` between rows of fingers, `0.6·pitch_um` between
    /// pits, `pitch_um` between domes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_um: Option<f64>,
}

/// About the regularity of the *Elaphe* scan, where finger spacings are within 10 % of their mean.
fn default_regularity() -> f64 {
    0.7
}

/// Levelling of a measured surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// As measured.
    #[default]
    None,
    /// Least-squares plane removed.
    Plane,
    /// Median of each row removed (scan-line offsets).
    Rows,
}

/// Expansion of the phase function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// Taylor series about the mid-range height.
    Taylor,
    /// Taylor series about the lowest height, as in the texts.
    TaylorZero,
    /// Chebyshev polynomials of the height, Bessel functions of `z` (Jacobi and Anger).
    Chebyshev,
    /// Singular functions over the z range and the heights of the surface.
    Optimal,
}

/// How the amplitude at a frequency is computed from a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Reconstruction {
    /// As a sum over the bins of the patch, weighted by the window's spectrum.
    Window,
    /// As one interpolated value of a table whose terms were multiplied by the window.
    Prefiltered,
}

/// How a shader interpolates between the texels of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampling {
    /// It loads four texels and mixes them.
    Load,
    /// It takes one sample through a linear filter.
    Filter,
}

/// A kind of light that a shader has a function for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightFunction {
    /// A single direction.
    Direction,
    /// A cap of the sphere.
    Disc,
    /// A spherical polygon.
    Polygon,
    /// Surroundings: a sky, a map.
    Environment,
    /// Random directions for path tracers.
    Path,
}

/// A number, or `auto`: the tool chooses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Auto<T> {
    /// As configured.
    Value(T),
    /// Chosen from the surface and an error.
    Auto,
}

impl<T: fmt::Display> fmt::Display for Auto<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Auto::Value(value) => value.fmt(f),
            Auto::Auto => f.write_str("auto"),
        }
    }
}

impl<T: Serialize> Serialize for Auto<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Auto::Value(value) => value.serialize(serializer),
            Auto::Auto => serializer.serialize_str("auto"),
        }
    }
}

/// Uniform wavelength samples, nm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wavelengths {
    /// First sample, nm.
    pub min_nm: f64,
    /// Last sample, nm.
    pub max_nm: f64,
    /// Distance between samples, nm.
    pub step_nm: f64,
}

impl Wavelengths {
    /// Visible light: the range of the colour tables, nm.
    pub const VISIBLE_NM: [f64; 2] = [380.0, 780.0];
}

/// Number format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TableFormat {
    /// 32-bit float.
    F32,
    /// 16-bit float, with a scale for each term.
    F16,
    /// Three numbers of nine bits with one common exponent. Only for `baked`, since the format has no sign and colours
    /// need none.
    Rgb9e5,
}

/// A file format of tables, in addition to the raw texels, which are always written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Container {
    /// Khronos texture, version 2.
    Ktx2,
    /// OpenEXR, the layers side by side in one picture.
    Exr,
}

/// How complex terms are stored in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Packing {
    /// Two complex terms per RGBA texel.
    Paired,
    /// One complex term per RG texel.
    Single,
}

/// A combination of axis values that cannot be built, and the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rejected {
    /// The name that the variant would have had.
    pub name: String,
    /// The constraint that it breaks.
    pub reason: String,
}

/// A checked plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Folder of the file; paths in the plan are relative to it.
    pub folder: PathBuf,
    /// SHA-256 of the text, hexadecimal.
    pub text_hash: String,
    /// The surfaces in the order of the file.
    pub surfaces: Vec<SurfaceSpec>,
    /// `[optics]`, the defaults of every variant. Surfaces may override them, see [`Variant::on`].
    pub optics: Optics,
    /// The variants: first the product of the axes, then the presets. Names are unique.
    pub variants: Vec<Variant>,
    /// Combinations of axis values that a constraint rejects, in the order of the product.
    pub rejected: Vec<Rejected>,
    /// Target languages to emit.
    pub targets: Vec<Target>,
    /// File formats of tables in addition to `.bin`, each once.
    pub containers: Vec<Container>,
    /// Notes for the user. They are not errors.
    pub notes: Vec<String>,
}
