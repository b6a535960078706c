//! Tables in files that engines read: KTX2, as the texture that it is, and OpenEXR, its layers side by side.
//!
//! The raw texels remain the normative form; a container holds the same bits, not compressed, so that its bytes depend
//! on nothing but the texels.

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
    /// Bytes of the texels, if a file can have as many.
    pub fn byte_count(&self) -> Option<usize> {
        [self.height, self.layers.max(1), self.format.texel_bytes()]
            .iter()
            .try_fold(self.width, |product, factor| product.checked_mul(*factor))
    }

    /// Numbers in a layer.
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

/// Where the layers of a table lie in a picture: row by row, from its upper left.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Atlas {
    /// Layers in a row of the picture.
    pub columns: usize,
    /// Rows of layers; the last may be incomplete, its rest is 0.
    pub rows: usize,
    /// Width of the picture.
    pub width: usize,
    /// Height of the picture.
    pub height: usize,
    /// Texel `(column, row)` of layer `n` is pixel `(x + column, y + row)`, where `[x, y]` is element `n`; pixel (0, 0) is
    /// the upper left one.
    pub offsets: Vec<[usize; 2]>,
}

impl Atlas {
    /// As few columns as make the picture at least as wide as it is high.
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

/// What the description of a table says about a container.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ContainerEntry {
    /// File beside the description.
    pub file: String,
    /// `VkFormat`, of KTX2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vk_format: Option<&'static str>,
    /// Names of the channels in the order of the table's, of OpenEXR.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channels: Option<&'static [&'static str]>,
    /// Where the layers lie, of OpenEXR.
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

/// The file of a table whose raw texels are given.
pub fn encode(container: Container, shape: &Shape, texels: &[u8]) -> Result<Vec<u8>> {
    if shape.byte_count() != Some(texels.len()) {
        return Err(failed(container, "the texels do not have the size of the table"));
    }
    match container {
        Container::Ktx2 => ktx2::encode(shape, texels),
        Container::Exr => openexr::file(shape, texels),
    }
}

/// The raw texels of a file that [`encode`] made; `None` of any other file, or of a table of another shape.
pub fn decode(container: Container, shape: &Shape, file: &[u8]) -> Option<Vec<u8>> {
    let texels = match container {
        Container::Ktx2 => ktx2::texels(shape, file),
        Container::Exr => openexr::texels(shape, file),
    }?;
    // everything that is not a texel is as it should be
    (encode(container, shape, &texels).ok()? == file).then_some(texels)
}

fn failed(container: Container, cause: &str) -> Error {
    Error::new(format!("{} table", container.as_str()), cause)
}
