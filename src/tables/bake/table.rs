//! The table of colours over `(u, v, w)`.

use crate::plan::TableFormat;
use crate::tables::{BakedAxes, TERMS, Table, colour_format};

use super::Colours;

/// The table, a 2-D array. Level `level` of page `page` is layer `page·levels + level`. The last column of a page is
/// the first of the next.
pub fn table(colours: &Colours, format: TableFormat) -> Table {
    let shape = shape(&colours.axes, format);
    let axes = &colours.axes;
    let (columns, rows) = (axes.columns as usize, axes.rows as usize);
    let (page, levels) = (axes.page_columns() as usize, axes.levels as usize);
    let channels = shape.format.channels();
    let mut texels = Vec::with_capacity(shape.width * shape.height * shape.layers * channels);
    for layer in 0..shape.layers {
        for row in 0..rows {
            let line = ((layer % levels) * rows + row) * columns;
            for column in 0..=page {
                let xyz = colours.xyz[line + (layer / levels * page + column) % columns];
                texels.extend(xyz.map(|c| f64::from(c) * axes.colour_scale()));
                texels.resize(texels.len() + channels - 3, 0.0);
            }
        }
    }
    Table { texels, ..shape }
}

/// The table without its texels.
pub fn shape(axes: &BakedAxes, format: TableFormat) -> Table {
    Table {
        name: "colours",
        binding: TERMS,
        format: colour_format(format),
        width: axes.page_columns() as usize + 1,
        height: axes.rows as usize,
        layers: (axes.pages * axes.levels) as usize,
        filtered: false,
        texels: Vec::new(),
    }
}
