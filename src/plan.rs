//! `plan.toml` as pure data: surfaces, optics, the axes of the variants, targets.

mod axis;
mod item;
mod local;
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

pub use local::SurfaceOptics;
pub use mode::Mode;
pub use optics::{Coherence, CoherenceScaling, Colour, Illuminant, Optics, Window};
pub use target::Target;
pub use variant::Variant;
pub use variants::MAX_VARIANTS;
pub use vocabulary::{AxisDoc, Key, axis_docs, vocabulary};

/// One surface of a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfaceSpec {
    /// `[a-z0-9-]+`, unique in the plan.
    pub name: String,
    /// Where the heights come from.
    pub source: SurfaceSource,
    /// Rotation of the surface about its normal, degrees, counter-clockwise seen from above; rotates `(u, v)` exactly.
    pub rotate_deg: f64,
    /// Levelling applied to the heights.
    pub level: Level,
    /// Share of the heights, in percent, clipped at each end as outliers.
    pub clip_percent: f64,
    /// Light and material of this surface, over `[optics]`.
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

/// A measured height field.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FileSource {
    /// Already resolved against the plan's folder.
    pub path: PathBuf,
    /// Width of the patch in µm; excludes `pixel_um`.
    pub size_um: Option<f64>,
    /// Pixel pitch in µm; excludes `size_um`.
    pub pixel_um: Option<f64>,
    /// Height of the full grey range of an integer file, µm.
    pub height_um: Option<f64>,
    /// Scale of a float file's numbers, µm per unit.
    pub z_unit_um: Option<f64>,
}

/// A synthetic surface; `x` grows with the column, one period (or one patch) is tiled.
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
        /// Place of the apex, `0 < apex < 1`.
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

/// Keys of the random surfaces; the module of synthetic height fields has their formulas.
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
    /// Order of the placement, from 0 (as irregular as the kind allows) to 1 (a perfect lattice).
    #[serde(default = "default_regularity")]
    pub regularity: f64,
    /// Distance of features along y, µm: of rows of fingers (default `2.6·pitch_um`), of pits (`0.6·pitch_um`), of
    /// domes (`pitch_um`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_um: Option<f64>,
}

/// About what the *Elaphe* scan shows: finger spacings within 10 % of their mean.
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

/// How the amplitude at any frequency comes from a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Reconstruction {
    /// A sum over the bins of the patch under the window's spectrum.
    Window,
    /// One value between the texels of a table that has the window in it already.
    Prefiltered,
}

/// How a shader reads what lies between the texels of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampling {
    /// Four loads, mixed by the shader.
    Load,
    /// One sample through a linear filter.
    Filter,
}

/// A number that may be left to the tool.
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
    /// Distance of samples, nm.
    pub step_nm: f64,
}

/// Number format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TableFormat {
    /// 32-bit float.
    F32,
    /// 16-bit float, with a scale for each term.
    F16,
    /// Three numbers of nine bits with one exponent, of `baked` only: colours have no sign.
    Rgb9e5,
}

/// A file form of tables beside the raw texels, which are always written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Container {
    /// Khronos texture, version 2.
    Ktx2,
    /// OpenEXR, the layers side by side in one picture.
    Exr,
}

/// How complex terms lie in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Packing {
    /// Two complex terms per RGBA texel.
    Paired,
    /// One complex term per RG texel.
    Single,
}

/// A combination of the product that cannot be built, and why.
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
    /// In the order of the file.
    pub surfaces: Vec<SurfaceSpec>,
    /// `[optics]`, the base of every variant's; surfaces may have their own over it, see [`Variant::on`].
    pub optics: Optics,
    /// Product first, then presets; names are unique.
    pub variants: Vec<Variant>,
    /// Combinations of the product that a constraint rejects, in the order of the product.
    pub rejected: Vec<Rejected>,
    /// Languages to emit.
    pub targets: Vec<Target>,
    /// File forms of tables beside `.bin`, each once.
    pub containers: Vec<Container>,
    /// What a user may want to know though nothing is wrong.
    pub notes: Vec<String>,
}
