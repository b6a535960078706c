//! KTX2: one level of a 2-D texture or 2-D array texture, without supercompression.
//!
//! The file has a header, the index of levels, the data format descriptor, keys and values, padding to a multiple of
//! the texel's size (itself a multiple of four), and the texels.

use ktx2::dfd::{Basic, Block};
use ktx2::{Format, Header, Index, LevelIndex};

use crate::error::Result;
use crate::plan::Container;
use crate::tables::TexelFormat;

use super::{Shape, failed};

/// Sorted by key, as the format requires. `rd`: columns to the right, row 0 at the top.
const KEYS: [(&str, &str); 2] = [("KTXorientation", "rd"), ("KTXwriter", "diffraction-shaders")];

/// Vulkan's name of a format, and the format.
pub(super) fn format(format: TexelFormat) -> (&'static str, Format) {
    match format {
        TexelFormat::Rg16Float => ("VK_FORMAT_R16G16_SFLOAT", Format::R16G16_SFLOAT),
        TexelFormat::Rgba16Float => ("VK_FORMAT_R16G16B16A16_SFLOAT", Format::R16G16B16A16_SFLOAT),
        TexelFormat::Rg32Float => ("VK_FORMAT_R32G32_SFLOAT", Format::R32G32_SFLOAT),
        TexelFormat::Rgba32Float => ("VK_FORMAT_R32G32B32A32_SFLOAT", Format::R32G32B32A32_SFLOAT),
        TexelFormat::Rgb9e5Ufloat => {
            ("VK_FORMAT_E5B9G9R9_UFLOAT_PACK32", Format::E5B9G9R9_UFLOAT_PACK32)
        }
    }
}

pub(super) fn encode(shape: &Shape, texels: &[u8]) -> Result<Vec<u8>> {
    let error = |cause: &str| failed(Container::Ktx2, cause);
    let number = |n: usize| {
        u32::try_from(n)
            .map_err(|_| error("is larger than the format allows").remedy("choose a smaller table"))
    };
    let (_, format) = format(shape.format);
    let (mut basic, type_size) =
        Basic::from_format(format).map_err(|e| error("has no data format descriptor").source(e))?;
    // the numbers are not colours
    basic.color_primaries = None;
    let block = Block::Basic(basic).to_vec();
    let descriptor_bytes = number(4 + block.len())?;
    let mut keys = Vec::new();
    for (key, value) in KEYS {
        let pair = [key.as_bytes(), &[0], value.as_bytes(), &[0]].concat();
        keys.extend(number(pair.len())?.to_le_bytes());
        keys.extend(pair);
        keys.resize(keys.len().next_multiple_of(4), 0);
    }
    let texel_bytes = shape.format.texel_bytes();
    let dfd_byte_offset = number(Header::LENGTH + LevelIndex::LENGTH)?;
    let kvd_byte_offset = dfd_byte_offset + descriptor_bytes;
    let kvd_byte_length = number(keys.len())?;
    // a texel has 4, 8 or 16 bytes, so its size is its least common multiple with 4
    let start = (kvd_byte_offset + kvd_byte_length).next_multiple_of(number(texel_bytes)?);
    let header = Header {
        format: Some(format),
        type_size,
        pixel_width: number(shape.width)?,
        pixel_height: number(shape.height)?,
        pixel_depth: 0,
        layer_count: number(shape.layers)?,
        face_count: 1,
        level_count: 1,
        supercompression_scheme: None,
        index: Index {
            dfd_byte_offset,
            dfd_byte_length: descriptor_bytes,
            kvd_byte_offset,
            kvd_byte_length,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };
    let length = texels.len() as u64;
    let level = LevelIndex {
        byte_offset: u64::from(start),
        byte_length: length,
        uncompressed_byte_length: length,
    };
    let mut file = Vec::with_capacity(start as usize + texels.len());
    file.extend(header.as_bytes());
    file.extend(level.as_bytes());
    file.extend(descriptor_bytes.to_le_bytes());
    file.extend(block);
    file.extend(keys);
    file.resize(start as usize, 0);
    file.extend(texels);
    Ok(file)
}

/// The bytes at the position of the texels, which is the end of the file.
pub(super) fn texels(shape: &Shape, file: &[u8]) -> Option<Vec<u8>> {
    let start = file.len().checked_sub(shape.byte_count()?)?;
    file.get(start..).map(<[u8]>::to_vec)
}
