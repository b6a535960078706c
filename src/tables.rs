//! The tables that shaders read: the inputs of each ([`TableSpec`]), its texels, and the files that contain them.

pub mod basis;
pub mod terms;
mod axes;
pub mod bake;
pub mod container;
mod cells;
mod corridor;
mod lobes;
mod matter;
mod meaning;
mod number;
pub mod orders;
pub mod paths;
mod period;
mod scale;
mod series;
mod spec;
pub mod streaks;
mod wide;

use serde::{Deserialize, Serialize};

use rustfft::num_complex::Complex64;

use crate::error::{Error, Result};
use crate::field::transform::Bins;
use crate::light::Filtered;
use crate::light::environment::filtered;
use crate::optics::spectrum::Sample;
use crate::plan::{Packing, TableFormat};
use crate::tables::basis::Expansion;
use crate::tables::terms::Terms;

pub use axes::{Aim, BEND, BakedAxes, octant};
pub use cells::cells_shape;
pub use corridor::{BROADEST, Corridor, LobeGeometry, MIN_SQUARED, OUTER_NODES, REACH_SIGMAS};
pub use matter::MatterSpec;
pub use meaning::{Meaning, NODE_LEVELS};
pub use period::{strongest_period_bytes, strongest_period_um};
pub use series::{Choice, LaidExpansion, Reach, Series};
pub use spec::*;
pub use wide::{PACKED, WideAxes, WideLevel, lobe_sigma};

/// Texel format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TexelFormat {
    /// Two 16-bit floats.
    Rg16Float,
    /// Four 16-bit floats.
    Rgba16Float,
    /// Two 32-bit floats.
    Rg32Float,
    /// Four 32-bit floats.
    Rgba32Float,
    /// Three numbers of nine bits with a common exponent of five bits.
    Rgb9e5Ufloat,
}

impl TexelFormat {
    /// Number of channels.
    pub fn channels(self) -> usize {
        match self {
            TexelFormat::Rg16Float | TexelFormat::Rg32Float => 2,
            TexelFormat::Rgba16Float | TexelFormat::Rgba32Float => 4,
            TexelFormat::Rgb9e5Ufloat => 3,
        }
    }

    /// Bytes of a texel.
    pub fn texel_bytes(self) -> usize {
        match self {
            TexelFormat::Rg16Float | TexelFormat::Rgb9e5Ufloat => 4,
            TexelFormat::Rg32Float | TexelFormat::Rgba16Float => 8,
            TexelFormat::Rgba32Float => 16,
        }
    }

    /// Whether its numbers are 32-bit floats.
    pub fn is_single(self) -> bool {
        matches!(self, TexelFormat::Rg32Float | TexelFormat::Rgba32Float)
    }

    /// The largest number that it holds.
    pub fn max(self) -> f64 {
        match self {
            TexelFormat::Rg16Float | TexelFormat::Rgba16Float => 65504.0,
            TexelFormat::Rg32Float | TexelFormat::Rgba32Float => f64::from(f32::MAX),
            // nine bits, exponents up to 31 with a bias of 15
            TexelFormat::Rgb9e5Ufloat => 511.0 / 512.0 * 65536.0,
        }
    }

    /// WebGPU's name of the format.
    pub fn name(self) -> &'static str {
        match self {
            TexelFormat::Rg16Float => "rg16float",
            TexelFormat::Rgba16Float => "rgba16float",
            TexelFormat::Rg32Float => "rg32float",
            TexelFormat::Rgba32Float => "rgba32float",
            TexelFormat::Rgb9e5Ufloat => "rgb9e5ufloat",
        }
    }
}

/// Texel format of a table of colours in a number format.
pub fn colour_format(format: TableFormat) -> TexelFormat {
    match format {
        TableFormat::F32 => TexelFormat::Rgba32Float,
        TableFormat::F16 => TexelFormat::Rgba16Float,
        TableFormat::Rgb9e5 => TexelFormat::Rgb9e5Ufloat,
    }
}

/// A table as a texture, `[layer][row][column][channel]`, in f64 until it is rounded.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the binding in the shader: `terms`, `spectrum`.
    pub name: &'static str,
    /// Binding in group 0. Binding 0 is the uniform block, 3 the probe's directions.
    pub binding: u32,
    /// Texel format.
    pub format: TexelFormat,
    /// Texels along x.
    pub width: usize,
    /// Texels along y.
    pub height: usize,
    /// Number of array layers; 0 for a plain two-dimensional texture.
    pub layers: usize,
    /// Whether shaders read it between texels, through the linear filter of binding [`SAMPLER`]. If not, they read single texels.
    pub filtered: bool,
    /// The numbers, row-major. Empty if only the shape is known.
    pub texels: Vec<f64>,
}

/// The levels of surroundings as a texture of 16-bit floats, and the factor by which their radiance was divided to fit.
pub fn environment_table(surroundings: &Filtered) -> (Table, f64) {
    let texels = surroundings.picture();
    let most = texels.iter().flatten().fold(0.0_f32, |most, value| most.max(*value));
    let format = TexelFormat::Rgba16Float;
    let factor = (f64::from(most) / (0.5 * format.max())).max(1.0);
    let texel = |[r, g, b]: [f32; 3]| [r, g, b, 1.0].map(|value| f64::from(value) / factor);
    let table = Table {
        name: "environment",
        binding: ENVIRONMENT,
        format,
        width: filtered::WIDTH,
        height: filtered::HEIGHT,
        layers: 0,
        filtered: true,
        texels: texels.into_iter().flat_map(texel).collect(),
    };
    (table, factor)
}

impl Table {
    /// Stands for a missing table.
    pub const ABSENT: Table = Table {
        name: "",
        binding: 0,
        format: TexelFormat::Rgba32Float,
        width: 0,
        height: 0,
        layers: 0,
        filtered: false,
        texels: Vec::new(),
    };

    /// Checks that its format can hold every number: none is infinite, not a number or too large.
    fn check(&self) -> Result<()> {
        self.check_from(0)
    }

    /// The same for layers from `first` on.
    fn check_from(&self, first: usize) -> Result<()> {
        let max = self.format.max();
        let fits = |number: &f64| number.abs() <= max;
        let Some(at) = self.texels.iter().position(|number| !fits(number)) else { return Ok(()) };
        let (texel, channel) = (at / self.format.channels(), at % self.format.channels());
        let (column, row) = (texel % self.width, texel / self.width % self.height);
        let cause = format!(
            "channel {channel} at column {column}, row {row}, layer {} is {}, which {} cannot hold",
            first + texel / (self.width * self.height),
            self.texels[at],
            self.format.name()
        );
        Err(Error::new(format!("table {}", self.name), cause).remedy(
            "use a basis whose terms are smaller, such as basis = \"optimal\", or table = \"f32\"",
        ))
    }

    /// The table with numbers as the shader reads them: rounded to the texel format.
    #[must_use]
    pub fn rounded(mut self) -> Table {
        self.format.round(&mut self.texels);
        self
    }

    /// The bytes to upload and to write to `.bin`, little-endian.
    pub fn bytes(&self) -> Vec<u8> {
        self.format.encode(&self.texels)
    }

    /// The table with the (rounded) numbers of [`Table::bytes`].
    #[must_use]
    pub fn with_bytes(self, bytes: &[u8]) -> Table {
        Table { texels: self.format.decode(bytes), ..self }
    }

    /// Number of texels.
    pub fn texel_count(&self) -> usize {
        self.width * self.height * self.layers.max(1)
    }

    /// Size in bytes.
    pub fn byte_count(&self) -> usize {
        self.texel_count() * self.format.texel_bytes()
    }

    /// A texel. Missing channels are 0, alpha included; after `textureLoad` a missing alpha would be 1.
    pub fn load(&self, column: i64, row: i64, layer: usize) -> [f64; 4] {
        let inside =
            (0..self.width as i64).contains(&column) && (0..self.height as i64).contains(&row);
        if !inside || layer >= self.layers.max(1) {
            return [0.0; 4];
        }
        let channels = self.format.channels();
        let start =
            ((layer * self.height + row as usize) * self.width + column as usize) * channels;
        std::array::from_fn(|c| if c < channels { self.texels[start + c] } else { 0.0 })
    }
}

/// The value of a linear filter, clamped to the edge, on one layer. `place` is in texels; whole numbers are the centres
/// of texels. The result is exact, whereas drivers round the weights, some to 8 bits.
pub fn bilinear(table: &Table, place: [f64; 2], layer: usize) -> [f64; 4] {
    let last = [table.width, table.height].map(|count| count as f64 - 1.0);
    let inside = [0, 1].map(|axis| place[axis].clamp(0.0, last[axis]));
    let first = inside.map(f64::floor);
    let part = [inside[0] - first[0], inside[1] - first[1]];
    let texel = |right: i64, up: i64| {
        let at = [first[0] as i64 + right, first[1] as i64 + up];
        table.load(at[0].min(last[0] as i64), at[1].min(last[1] as i64), layer)
    };
    let mix = |a: [f64; 4], b: [f64; 4], t: f64| std::array::from_fn(|c| a[c] + t * (b[c] - a[c]));
    let rows = [0, 1].map(|row| mix(texel(0, row), texel(1, row), part[0]));
    mix(rows[0], rows[1], part[1])
}

/// Binding of the largest table: of terms, colours or efficiencies.
pub const TERMS: u32 = 1;
/// Binding of the spectrum table.
pub const SPECTRUM: u32 = 2;
/// Binding of the probe's directions.
pub const DIRECTIONS: u32 = 3;

/// Binding of the table of coefficients, of moments, or of colours with wider lobes.
pub const COEFFICIENTS: u32 = 4;
/// Binding of the table of streaks, or of cells.
pub const STREAKS: u32 = 6;
/// Binding of the levels of the surroundings in whole shaders.
pub const ENVIRONMENT: u32 = 7;
/// Binding of the table of paths.
pub const PATHS: u32 = 10;
/// Binding of the sampler.
pub const SAMPLER: u32 = 5;
/// Name of the sampler in the templates. `linear` is a keyword of HLSL. From this name Unity derives the filter and the
/// address mode.
pub const SAMPLER_NAME: &str = "linear_clamp";

/// Scales of the terms in a table of 16-bit floats: term `n` is stored divided by `first · ratio^n`.
///
/// A geometric sequence costs the shader only one texel per pixel: the ratio is a factor of the series' argument, the
/// first scale a factor of its result. Both are 32-bit numbers, so that packer, shader and twin use the same values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TermScale {
    /// Scale of term 0.
    pub first: f64,
    /// Scale of a term divided by the scale of the previous term.
    pub ratio: f64,
}

impl TermScale {
    /// The scales of a table of 32-bit floats.
    pub const NONE: TermScale = TermScale { first: 1.0, ratio: 1.0 };

    /// Scale of a term.
    pub fn of(&self, term: usize) -> f64 {
        (0..term).fold(self.first, |scale, _| scale * self.ratio)
    }
}

/// The term table, a 2-D array. `paired`: texel `(r, s)` of layer `p` has terms `2p` (red, green) and `2p+1` (blue,
/// alpha; zero if this term does not exist). `single`: layer `n` has term `n`. Column 0 is bin `-r_max`, row 0 is bin
/// `-s_max`.
pub fn terms_table(
    terms: &Terms,
    packing: Packing,
    format: TableFormat,
    scale: TermScale,
) -> Table {
    let shape = terms_shape(terms.bins, terms.tables.len(), packing, format);
    let mut layers = TermLayers::new(terms.bins, packing, format, scale);
    let mut texels = Vec::with_capacity(shape.texel_count() * shape.format.channels());
    let added = terms.tables.iter().filter_map(|term| layers.add(term.clone())).collect::<Vec<_>>();
    for (layer, _) in added.into_iter().chain(layers.finish()) {
        texels.extend(layer.texels);
    }
    Table { texels, ..shape }
}

/// Makes the layers of a term table from one term after the other.
struct TermLayers {
    shape: Table,
    scale: TermScale,
    /// Terms of a layer that is not complete.
    waiting: Vec<Vec<Complex64>>,
    /// Number of layers that were made.
    made: usize,
}

impl TermLayers {
    fn new(bins: Bins, packing: Packing, format: TableFormat, scale: TermScale) -> TermLayers {
        let shape = terms_shape(bins, 1, packing, format);
        TermLayers { shape, scale, waiting: Vec::new(), made: 0 }
    }

    /// Number of terms in a layer.
    fn per_layer(&self) -> usize {
        self.shape.format.channels() / 2
    }

    /// Takes the next term. Returns a layer and its number once the layer is complete.
    fn add(&mut self, term: Vec<Complex64>) -> Option<(Table, usize)> {
        self.waiting.push(term);
        if self.waiting.len() == self.per_layer() { self.finish() } else { None }
    }

    /// The last layer with its number, if it has terms. Channels of terms that do not exist are 0.
    fn finish(&mut self) -> Option<(Table, usize)> {
        let terms = std::mem::take(&mut self.waiting);
        if terms.is_empty() {
            return None;
        }
        let per_layer = self.per_layer();
        let scales: Vec<f64> =
            (0..per_layer).map(|i| self.scale.of(self.made * per_layer + i)).collect();
        let count = self.shape.width * self.shape.height;
        let mut texels = Vec::with_capacity(count * self.shape.format.channels());
        for bin in 0..count {
            for (slot, scale) in scales.iter().enumerate() {
                let term = terms.get(slot);
                let (re, im) = term.map_or((0.0, 0.0), |term| (term[bin].re, term[bin].im));
                texels.extend([re / scale, im / scale]);
            }
        }
        let made = self.made;
        self.made += 1;
        Some((Table { texels, ..self.shape.clone() }, made))
    }
}

/// The term table without its texels.
pub fn terms_shape(bins: Bins, terms: usize, packing: Packing, format: TableFormat) -> Table {
    let (format, per_texel) = match (packing, format) {
        (Packing::Paired, TableFormat::F32) => (TexelFormat::Rgba32Float, 2),
        (Packing::Single, TableFormat::F32) => (TexelFormat::Rg32Float, 1),
        (Packing::Paired, TableFormat::F16) => (TexelFormat::Rgba16Float, 2),
        (Packing::Single, TableFormat::F16) => (TexelFormat::Rg16Float, 1),
        // there are no terms: the colours have a table of their own
        (_, TableFormat::Rgb9e5) => (TexelFormat::Rgb9e5Ufloat, 1),
    };
    let layers = terms.div_ceil(per_texel);
    Table {
        name: "terms",
        binding: TERMS,
        format,
        width: bins.width(),
        height: bins.height(),
        layers,
        filtered: false,
        texels: Vec::new(),
    }
}

/// The table of coefficients, 2-D, with `width` columns. Column `i` is `z = (i/(width - 1) - 1)·z_max`. Row `q` has the
/// coefficients of terms `4q` to `4q + 3`, zero for terms that do not exist.
pub fn coefficients_table(expansion: &Expansion, width: usize) -> Table {
    let terms = expansion.terms as usize;
    let shape = coefficients_shape(expansion.terms, width);
    let mut texels = Vec::with_capacity(4 * width * shape.height);
    for row in 0..shape.height {
        for column in 0..width {
            let tau = column as f64 / (width - 1) as f64 - 1.0;
            texels.extend(
                (4 * row..4 * row + 4)
                    .map(|n| if n < terms { expansion.coefficient(n, tau) } else { 0.0 }),
            );
        }
    }
    Table { texels, ..shape }
}

/// The table of coefficients without its texels.
fn coefficients_shape(terms: u32, width: usize) -> Table {
    Table {
        name: "coefficients",
        binding: COEFFICIENTS,
        format: TexelFormat::Rgba32Float,
        width,
        height: terms.div_ceil(4) as usize,
        layers: 0,
        filtered: false,
        texels: Vec::new(),
    }
}

/// Numbers in row 1 of every spectrum table.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Rotation of the surface, degrees.
    pub rotate_deg: f64,
    /// Scales of the terms.
    pub scale: TermScale,
    /// Rows about the matter, below all others.
    pub matter: Option<MatterSpec>,
}

impl Settings {
    /// Only a rotation.
    pub fn rotated(rotate_deg: f64) -> Settings {
        Settings { rotate_deg, scale: TermScale::NONE, matter: None }
    }

    fn append(&self, table: &mut Table) {
        if let Some(matter) = &self.matter {
            matter.append(table);
        }
    }
}

/// The spectrum table, 2-D. Row 0: one texel per node, with X, Y, Z weights (for uniform wavelengths with the
/// quadrature weight; for wavenumbers per 1/µm) and λ in µm. Row 1, first texel: cosine and sine of the surface's
/// rotation, scale of the first term, ratio of the scales.
pub fn spectrum_table(samples: &[Sample], settings: Settings) -> Table {
    let texels =
        samples.iter().map(|s| [s.xyz[0], s.xyz[1], s.xyz[2], s.lambda_nm * 1e-3]).collect();
    let mut table = two_rows(texels, &settings);
    settings.append(&mut table);
    table
}

/// A spectrum table of one wavelength in nm with weight 1. A shader with it returns `C·|P|²` at that wavelength.
pub fn single_wavelength(lambda_nm: f64, settings: Settings) -> Table {
    spectrum_table(&[Sample { lambda_nm, xyz: [1.0; 3] }], settings)
}

/// The spectrum table of nodes that depend on `|(u, v)|`. Each level has a row: the first level row 0, the others rows
/// from 2 on. Row 1 is as in [`spectrum_table`]. Texels after the last node of a row are 0. `columns`: the least number
/// of columns.
pub fn levels_table(levels: &[Vec<Sample>], columns: usize, settings: Settings) -> Table {
    let width = levels.iter().map(Vec::len).max().unwrap_or(1).max(columns);
    let mut rows = levels.iter().map(|samples| {
        let texel = |s: &Sample| [s.xyz[0], s.xyz[1], s.xyz[2], s.lambda_nm * 1e-3];
        let mut row: Vec<[f64; 4]> = samples.iter().map(texel).collect();
        row.resize(width, [0.0; 4]);
        row
    });
    let mut table = two_rows(rows.next().unwrap_or_default(), &settings);
    table.texels.extend(rows.flatten().flatten());
    table.height = levels.len() + 1;
    settings.append(&mut table);
    table
}

/// Spectrum table of the order sum `gems`. Row 0, first texel: the grating's period in µm, as a vector from one groove
/// to the next. Row 1 is as in [`spectrum_table`].
pub fn grating_table([x_um, y_um]: [f64; 2], rotate_deg: f64) -> Table {
    two_rows(vec![[x_um, y_um, 0.0, 0.0]], &Settings::rotated(rotate_deg))
}

/// Spectrum table for shaders that need only the rotation. Row 1 is as in [`spectrum_table`].
pub fn rotation_table(rotate_deg: f64) -> Table {
    two_rows(vec![[0.0; 4]], &Settings::rotated(rotate_deg))
}

/// Spectrum table for shaders with tables of wider lobes. Row 0: a texel for each, and
/// one with the reflectance at normal incidence. Row 1 is as in [`spectrum_table`].
pub fn spreads_table(levels: Vec<[f64; 4]>, rotate_deg: f64) -> Table {
    two_rows(levels, &Settings::rotated(rotate_deg))
}

/// The spectrum table of sums over lobes. Row 0: one texel per node, with X, Y, Z of the lobe about it and the
/// wavelength in µm at which its bin is evaluated. Row 1 is as in [`spectrum_table`]. The following rows have the same
/// for narrow lobes, `[half][row][column]`.
pub fn lobe_table(
    nodes: Vec<[f64; 4]>,
    narrow: Vec<[f64; 4]>,
    columns: usize,
    settings: Settings,
) -> Table {
    let mut first = nodes;
    first.resize(columns, [0.0; 4]);
    let mut table = two_rows(first, &settings);
    table.height += narrow.len() / columns;
    table.texels.extend(narrow.into_iter().flatten());
    settings.append(&mut table);
    table
}

fn two_rows(first: Vec<[f64; 4]>, settings: &Settings) -> Table {
    let (sin, cos) = settings.rotate_deg.to_radians().sin_cos();
    let width = first.len();
    let mut texels = first.concat();
    texels.extend([cos, sin, settings.scale.first, settings.scale.ratio]);
    texels.resize(2 * 4 * width, 0.0);
    Table { texels, ..spectrum_shape(width, 2) }
}

/// A spectrum table without its texels.
fn spectrum_shape(width: usize, height: usize) -> Table {
    Table {
        name: "spectrum",
        binding: SPECTRUM,
        format: TexelFormat::Rgba32Float,
        width,
        height,
        layers: 0,
        filtered: false,
        texels: Vec::new(),
    }
}
