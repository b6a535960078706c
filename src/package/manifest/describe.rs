//! The description beside the texels of a table.

use crate::plan::Container;
use crate::shader::template::GENERATED;
use crate::tables::container::entry;
use crate::tables::{Meaning, TableSpec};

use super::{SCHEMA_VERSION, TableDescription};

/// The description of a table under its name.
pub fn describe(spec: &TableSpec, id: &str, containers: &[Container]) -> TableDescription {
    let table = spec.shape();
    let shape = table.shape();
    let Meaning { channels, axes, scale, term_scales } = spec.meaning();
    TableDescription {
        generated_by: GENERATED,
        schema_version: SCHEMA_VERSION,
        id: id.to_owned(),
        data: format!("{id}.bin"),
        bytes: table.byte_count(),
        format: table.format.name(),
        endianness: "little",
        dimension: if table.layers == 0 { "2d" } else { "2d-array" },
        width: table.width,
        height: table.height,
        layers: table.layers.max(1),
        order: "[layer][row][column][channel]",
        channels,
        axes,
        scale,
        term_scales,
        wrap: "none: no texel outside is read",
        containers: containers.iter().map(|&c| (c, entry(c, &shape, id))).collect(),
    }
}
