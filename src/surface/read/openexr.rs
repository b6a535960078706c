//! OpenEXR: the first layer, with one channel of half or single precision or several equal ones, and Gwyddion's attributes.

use std::io::Cursor;

use exr::block::chunk::CompressedBlock;
use exr::compression::Compression;
use exr::image::FlatSamples;
use exr::image::read::read as reader;
use exr::math::Vec2;
use exr::meta::attribute::AttributeValue;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{ReadChannels, ReadLayers};

use super::{check_length, check_pixels, gwyddion};
use crate::error::{Error, Result};
use crate::plan::FileSource;
use crate::surface::raster::{Raster, Samples, Stated};

/// Maximum size in bytes of a tile, unless four times the layer is more. The crate allocates memory for a whole tile
/// before it reads one.
const MAX_TILE_BYTES: u64 = 16 << 20;

/// Reads a file whose magic number has been seen. The key `channel` chooses by name; without it channels have to be equal.
/// A channel named `A` is opacity and ignored, unless it is the only one.
pub(super) fn read(bytes: &[u8], source: &FileSource, subject: &str) -> Result<Raster> {
    let error = |cause: String| Error::new(subject, cause);
    let broken = |e: exr::error::Error| {
        error("the OpenEXR file cannot be decoded".into()).source(e).remedy(
            "the file is truncated, damaged or of a rare kind; export it again as scan lines",
        )
    };
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    check(&meta, bytes, subject)?;
    let image = reader()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    let (columns, rows) = (image.layer_data.size.x(), image.layer_data.size.y());
    let mut channels: Vec<_> = image.layer_data.channel_data.list.into_iter().collect();
    if let Some(wanted) = &source.channel {
        let names: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
        let is_wanted = |name: &str| name.eq_ignore_ascii_case(wanted.trim());
        channels.retain(|c| is_wanted(&c.name.to_string()));
        if channels.is_empty() {
            let cause =
                format!("`channel = {wanted}` is not in the file, which has {}", names.join(", "));
            return Err(error(cause).remedy("give the name of one of these channels"));
        }
    } else if channels.len() > 1 {
        channels.retain(|c| !c.name.eq("A"));
    }
    let mut heights: Option<(String, Vec<f64>)> = None;
    for channel in channels {
        let name = channel.name.to_string();
        let values: Vec<f64> = match channel.sample_data {
            FlatSamples::F16(v) => v.into_iter().map(|h| f64::from(h.to_f32())).collect(),
            FlatSamples::F32(v) => v.into_iter().map(f64::from).collect(),
            FlatSamples::U32(_) => {
                return Err(error(format!("channel {name} has 32-bit integers"))
                    .remedy("export half or float samples"));
            }
        };
        if values.len() != columns * rows {
            return Err(error(format!("channel {name} is subsampled"))
                .remedy("export it at full resolution"));
        }
        match &heights {
            None => heights = Some((name, values)),
            Some((first, known)) => {
                let same = |(a, b): (&f64, &f64)| a == b || (a.is_nan() && b.is_nan());
                if let Some(i) = known.iter().zip(&values).position(|pair| !same(pair)) {
                    let cause = format!(
                        "channels {first} and {name} differ at column {}, row {} ({} and {})",
                        i % columns,
                        i / columns,
                        known[i],
                        values[i]
                    );
                    return Err(error(cause).remedy(format!(
                        "choose one with `channel = \"{first}\"`, or export one channel"
                    )));
                }
            }
        }
    }
    let (_, values) = heights.ok_or_else(|| {
        error("the OpenEXR file has no channels".into()).remedy("export one channel of heights")
    })?;
    let notes = match meta.headers.len() {
        0 | 1 => Vec::new(),
        _ => vec!["the OpenEXR file has several layers; the first is used".to_owned()],
    };
    let stated = meta.headers.first().map_or_else(Stated::default, |h| stated(h, [columns, rows]));
    Ok(Raster { columns, rows, samples: Samples::Float(values), stated, notes })
}

/// Refuses a file whose header states more pixels or larger tiles than the file can have, or whose table of chunks points
/// elsewhere: the crate allocates before it reads.
pub fn check(meta: &MetaData, bytes: &[u8], subject: &str) -> Result<()> {
    let error = |cause: String| Error::new(subject, cause);
    let broken = |e: exr::error::Error| {
        error("the OpenEXR file cannot be decoded".into()).source(e).remedy(
            "the file is truncated, damaged or of a rare kind; export it again as scan lines",
        )
    };
    for header in &meta.headers {
        let (columns, rows) =
            check_pixels(subject, header.layer_size.x() as u64, header.layer_size.y() as u64)?;
        let total = columns as u64 * rows as u64 * header.channels.bytes_per_pixel as u64;
        check_length(subject, bytes.len(), total, header.compression != Compression::Uncompressed)?;
        if let BlockDescription::Tiles(tiles) = header.blocks {
            let (x, y) = (tiles.tile_size.x() as u64, tiles.tile_size.y() as u64);
            let tile = x.saturating_mul(y).saturating_mul(header.channels.bytes_per_pixel as u64);
            if tile > MAX_TILE_BYTES.max(4 * total) {
                let cause = format!(
                    "the file has tiles of {x} × {y} pixels for a layer of {columns} × {rows}"
                );
                return Err(error(cause).remedy("the file is damaged; export it again"));
            }
        }
    }
    check_chunks(bytes).map_err(broken)?.then_some(()).ok_or_else(|| {
        error("the table of chunks of the OpenEXR file points to other layers or levels".into())
            .remedy("the file is damaged; export it again")
    })
}

/// What the attributes of the picture and of its layer state.
fn stated(header: &Header, pixels: [usize; 2]) -> Stated {
    let text = |value: &AttributeValue| match value {
        AttributeValue::Text(text) => Some(text.to_string()),
        AttributeValue::F32(number) => Some(number.to_string()),
        AttributeValue::F64(number) => Some(number.to_string()),
        AttributeValue::I32(number) => Some(number.to_string()),
        _ => None,
    };
    let all = header.shared_attributes.other.iter().chain(&header.own_attributes.other);
    let entries: Vec<(String, String)> =
        all.filter_map(|(key, value)| Some((key.to_string(), text(value)?))).collect();
    gwyddion::stated(&entries, pixels)
}

/// Whether every chunk in the table of the first layer's largest level really belongs to that level. The crate does not
/// check this, and would write lines of a smaller level into the largest.
fn check_chunks(bytes: &[u8]) -> Result<bool, exr::error::Error> {
    let largest = Vec2(0, 0);
    let chunks = exr::block::read(Cursor::new(bytes), false)?
        .filter_chunks(false, |_, tile, block| block.layer == 0 && tile.level_index == largest)?;
    for chunk in chunks {
        let chunk = chunk?;
        let elsewhere = match chunk.compressed_block {
            CompressedBlock::Tile(tile) => tile.coordinates.level_index != largest,
            _ => false,
        };
        if elsewhere || chunk.layer_index != 0 {
            return Ok(false);
        }
    }
    Ok(true)
}
