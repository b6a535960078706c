//! Tables in files that engines can read: KTX2 with the texture as it is, and OpenEXR with the layers side by side.
//!
//! The raw texels remain the normative form. A container has the same bits, uncompressed, so its bytes depend only on
//! the texels.

mod ktx2;
mod openexr;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::plan::Container;

use super::{Table, TexelFormat};

/// Size and format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shape {
    /// Texel format.
    pub format: TexelFormat,
    /// Texels along x.
    pub width: usize,
    /// Texels along y.
    pub height: usize,
    /// Array layers; 0 for a plain two-dimensional texture.
    pub layers: usize,
}

impl Shape {
    /// Bytes of the texels, if this number does not overflow.
    pub fn byte_count(&self) -> Option<usize> {
        [self.height, self.layers.max(1), self.format.texel_bytes()]
            .iter()
            .try_fold(self.width, |product, factor| product.checked_mul(*factor))
    }

    /// Number of numbers in a layer.
    pub fn layer_numbers(&self) -> usize {
        self.width.saturating_mul(self.height).saturating_mul(self.format.channels())
    }
}

impl Table {
    /// Size and format.
    pub fn shape(&self) -> Shape {
        let Table { format, width, height, layers, .. } = *self;
        Shape { format, width, height, layers }
    }
}

/// Positions of a table's layers in a picture: row by row, from the upper left.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Atlas {
    /// Number of layers in a row of the picture.
    pub columns: usize,
    /// Number of rows of layers. The last row may be incomplete; unused pixels are 0.
    pub rows: usize,
    /// Width of the picture.
    pub width: usize,
    /// Height of the picture.
    pub height: usize,
    /// Element `n` is `[x, y]`: texel `(column, row)` of layer `n` is pixel `(x + column, y + row)` of the picture.
    /// Pixel (0, 0) is at the upper left.
    pub offsets: Vec<[usize; 2]>,
}

impl Atlas {
    /// The minimum number of columns for which the picture is at least as wide as high.
    pub fn new(shape: &Shape) -> Atlas {
        let Shape { width, height, layers, .. } = *shape;
        let layers = layers.max(1);
        let wide = |columns: &usize| columns * width >= layers.div_ceil(*columns) * height;
        let columns = (1..=layers).find(wide).unwrap_or(layers);
        let rows = layers.div_ceil(columns);
        let offset = |n: usize| [n % columns * width, n / columns * height];
        Atlas {
            columns,
            rows,
            width: columns * width,
            height: rows * height,
            offsets: (0..layers).map(offset).collect(),
        }
    }
}

/// A container in the description of a table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ContainerEntry {
    /// Name of the file, in the folder of the description.
    pub file: String,
    /// For KTX2: the `VkFormat`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vk_format: Option<&'static str>,
    /// For OpenEXR: names of the channels, in the order of the table's channels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channels: Option<&'static [&'static str]>,
    /// For OpenEXR: positions of the layers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub atlas: Option<Atlas>,
}

/// The entry of a table called `id`.
pub fn entry(container: Container, shape: &Shape, id: &str) -> ContainerEntry {
    let file = format!("{id}.{}", container.as_str());
    match container {
        Container::Ktx2 => {
            let vk_format = Some(ktx2::format(shape.format).0);
            ContainerEntry { file, vk_format, channels: None, atlas: None }
        }
        Container::Exr => ContainerEntry {
            file,
            vk_format: None,
            channels: Some(openexr::channels(shape.format)),
            atlas: Some(Atlas::new(shape)),
        },
    }
}

/// The file of a table with these raw texels.
pub fn encode(container: Container, shape: &Shape, texels: &[u8]) -> Result<Vec<u8>> {
    if shape.byte_count() != Some(texels.len()) {
        return Err(failed(container, "the number of texels does not match the size of the table"));
    }
    match container {
        Container::Ktx2 => ktx2::encode(shape, texels),
        Container::Exr => openexr::file(shape, texels),
    }
}

/// The raw texels of a file that [`encode`] wrote. `None` for any other file, and for a table of another shape.
pub fn decode(container: Container, shape: &Shape, file: &[u8]) -> Option<Vec<u8>> {
    let texels = match container {
        Container::Ktx2 => ktx2::texels(shape, file),
        Container::Exr => openexr::texels(shape, file),
    }?;
    // checks all bytes of the file that are not texels
    (encode(container, shape, &texels).ok()? == file).then_some(texels)
}

fn failed(container: Container, cause: &str) -> Error {
    Error::new(format!("{} table", container.as_str()), cause)
}
