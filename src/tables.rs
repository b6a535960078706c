//! Texel data of the tables that shaders read.

use crate::plan::{Packing, TableFormat};
use crate::spectrum::Sample;
use crate::terms::Terms;
use crate::transform::Bins;

/// Texel format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TexelFormat {
    /// Two 32-bit floats.
    Rg32Float,
    /// Four 32-bit floats.
    Rgba32Float,
}

impl TexelFormat {
    /// Numbers in a texel.
    pub fn channels(self) -> usize {
        match self {
            TexelFormat::Rg32Float => 2,
            TexelFormat::Rgba32Float => 4,
        }
    }

    /// WebGPU's name of the format.
    pub fn name(self) -> &'static str {
        match self {
            TexelFormat::Rg32Float => "rg32float",
            TexelFormat::Rgba32Float => "rgba32float",
        }
    }
}

/// A table as a texture, `[layer][row][column][channel]`, in f64 until it is rounded.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the binding in the shader: `terms`, `spectrum`.
    pub name: &'static str,
    /// Texel format.
    pub format: TexelFormat,
    /// Texels along x.
    pub width: usize,
    /// Texels along y.
    pub height: usize,
    /// Array layers; 0 for a plain two-dimensional texture.
    pub layers: usize,
    /// Numbers, row-major; empty where only the shape is known.
    pub texels: Vec<f64>,
}

impl Table {
    /// Numbers as the shader sees them: rounded to the texel format.
    #[must_use]
    pub fn rounded(mut self) -> Table {
        self.texels.iter_mut().for_each(|v| *v = f64::from(*v as f32));
        self
    }

    /// Little-endian bytes, as uploaded and as written to `.bin`.
    pub fn bytes(&self) -> Vec<u8> {
        self.texels.iter().flat_map(|&v| (v as f32).to_le_bytes()).collect()
    }

    /// Size in bytes.
    pub fn byte_count(&self) -> usize {
        self.width * self.height * self.layers.max(1) * self.format.channels() * size_of::<f32>()
    }

    /// A texel; missing channels are 0, as after `textureLoad` except that alpha is 0 too.
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

/// The term table, 2-D array. `paired`: texel `(r, s)` of layer `p` holds terms `2p` (red, green) and `2p+1` (blue,
/// alpha; zero if there is none); `single`: layer `n` holds term `n`. Column 0 is bin `-r_max`, row 0 is bin `-s_max`.
pub fn terms_table(terms: &Terms, packing: Packing, format: TableFormat) -> Table {
    let shape = terms_shape(terms.bins, terms.tables.len(), packing, format);
    let (format, layers) = (shape.format, shape.layers);
    let per_texel = format.channels() / 2;
    let mut texels = Vec::with_capacity(layers * terms.bins.len() * format.channels());
    for group in terms.tables.chunks(per_texel) {
        for bin in 0..terms.bins.len() {
            for slot in 0..per_texel {
                let (re, im) =
                    group.get(slot).map_or((0.0, 0.0), |table| (table[bin].re, table[bin].im));
                texels.extend([re, im]);
            }
        }
    }
    Table { texels, ..shape }
}

/// The term table without its texels.
pub fn terms_shape(bins: Bins, terms: usize, packing: Packing, format: TableFormat) -> Table {
    let TableFormat::F32 = format;
    let (format, per_texel) = match packing {
        Packing::Paired => (TexelFormat::Rgba32Float, 2),
        Packing::Single => (TexelFormat::Rg32Float, 1),
    };
    let layers = terms.div_ceil(per_texel);
    Table {
        name: "terms",
        format,
        width: bins.width(),
        height: bins.height(),
        layers,
        texels: Vec::new(),
    }
}

/// The spectrum table, 2-D. Row 0: one texel per wavelength node, X, Y, Z weights (quadrature included) and λ in µm.
/// Row 1, first texel: cosine and sine of the surface's rotation.
pub fn spectrum_table(samples: &[Sample], rotate_deg: f64) -> Table {
    let mut texels: Vec<f64> =
        samples.iter().flat_map(|s| [s.xyz[0], s.xyz[1], s.xyz[2], s.lambda_nm * 1e-3]).collect();
    let (sin, cos) = rotate_deg.to_radians().sin_cos();
    texels.extend([cos, sin, 0.0, 0.0]);
    texels.resize(2 * 4 * samples.len(), 0.0);
    Table {
        name: "spectrum",
        format: TexelFormat::Rgba32Float,
        width: samples.len(),
        height: 2,
        layers: 0,
        texels,
    }
}
