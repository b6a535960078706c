//! The meaning of a table's numbers, in words.

use std::collections::BTreeMap;

use crate::field::transform::Bins;
use crate::plan::Packing;

use super::orders::{CENTRE_NM, EfficiencyAxes, UNIT_NM, moment_columns};
use super::paths::{OrderPaths, path_columns, wavelength_cells};
use super::spec::{CoefficientsSpec, LobesSpec, WideSpec};
use super::{BakedAxes, MatterSpec, PACKED, Series, Table, TableSpec, TermScale};

/// Number of levels of `|(u, v)|`, from 0 to 2, each with wavelength nodes of its own.
pub const NODE_LEVELS: u32 = 64;

/// Meaning of the channels and axes of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Meaning {
    /// Meaning of each channel.
    pub channels: Vec<String>,
    /// Meaning of columns, rows and layers. A plain texture has no entry for layers.
    pub axes: BTreeMap<&'static str, String>,
    /// Factor that the stored numbers are to be multiplied by.
    pub scale: f64,
    /// One factor for each term, if terms have scales of their own.
    pub term_scales: Vec<f64>,
}

impl TableSpec {
    /// The meaning of the table's numbers.
    pub fn meaning(&self) -> Meaning {
        let (channels, axes) = match self {
            TableSpec::Terms(spec) => terms(&spec.series),
            TableSpec::Coefficients(spec) => coefficients(spec),
            TableSpec::Colours(spec) => colours(self.shape().format.channels(), &spec.axes),
            TableSpec::Wide(spec) => wide(self.shape().format.channels(), spec),
            TableSpec::Spreads(_) => spreads(),
            TableSpec::Nodes(spec) => nodes([spec.wavelengths.min_nm, spec.wavelengths.max_nm]),
            TableSpec::Levels(spec) if spec.counts.len() == 1 => nodes(spec.range_nm),
            TableSpec::Levels(spec) => levels(spec.range_nm),
            TableSpec::Lobes(spec) if spec.nodes == 1 => nodes(spec.range_nm),
            TableSpec::Lobes(spec) => lobes(spec),
            TableSpec::Grating(_) => grating(),
            TableSpec::Rotation(_) => rotation(),
            TableSpec::Efficiencies(spec) => efficiencies(&spec.axes),
            TableSpec::Moments(spec) => moments(spec.range_nm),
            TableSpec::Streaks(_) => streaks(),
            TableSpec::OrderPaths(spec) => order_paths(&spec.of),
            TableSpec::ColourPaths(_) => colour_paths(),
            TableSpec::Cells(_) => cells(),
        };
        let axes = match self.matter() {
            Some(matter) => with_matter(axes, &self.shape(), matter),
            None => axes,
        };
        let scale = match self {
            TableSpec::Colours(spec) => 1.0 / spec.axes.colour_scale(),
            TableSpec::Wide(spec) => {
                spec.wide.levels.first().map_or(1.0, |level| 1.0 / level.axes.colour_scale())
            }
            _ => 1.0,
        };
        let term_scales = match self {
            TableSpec::Terms(spec) if spec.series.scale() != TermScale::NONE => {
                (0..spec.series.terms() as usize).map(|n| spec.series.scale().of(n)).collect()
            }
            _ => Vec::new(),
        };
        Meaning { channels, axes, scale, term_scales }
    }
}

impl TableSpec {
    /// The rows about the matter.
    fn matter(&self) -> Option<&MatterSpec> {
        match self {
            TableSpec::Nodes(spec) => spec.settings.matter.as_ref(),
            TableSpec::Levels(spec) => spec.settings.matter.as_ref(),
            TableSpec::Lobes(spec) => spec.settings.matter.as_ref(),
            _ => None,
        }
    }
}

/// Adds the meaning of the rows about the matter.
fn with_matter(
    mut axes: BTreeMap<&'static str, String>,
    table: &Table,
    matter: &MatterSpec,
) -> BTreeMap<&'static str, String> {
    let first = table.height - matter.rows();
    let words = format!(
        "; from {first} on, with a column for each of {} equal steps of the wavelength: {}",
        table.width.max(2) - 1,
        matter.meaning()
    );
    axes.entry("row").or_default().push_str(&words);
    axes
}

type Words = (Vec<String>, BTreeMap<&'static str, String>);

fn terms(series: &Series) -> Words {
    let paired = series.packing == Packing::Paired;
    let names: &[&str] = if paired {
        &["re, even term", "im, even term", "re, odd term", "im, odd term"]
    } else {
        &["re", "im"]
    };
    let layer = if paired { "layer p holds terms 2p and 2p+1" } else { "layer n holds term n" };
    let (x, y) = (series.bins.r_max, series.bins.s_max);
    let bin = |axis: &str, centre: usize, l: f64| match series.grid {
        None => format!("bin {axis} = index - {centre}, frequency bin/{l} cycles per µm"),
        Some(_) => format!(
            "frequency (index - {centre})/{l} cycles per µm, linear between; the terms contain the coherence window"
        ),
    };
    let axes = BTreeMap::from([
        ("column", bin("r", x, series.size_um[0])),
        ("row", bin("s", y, series.size_um[1])),
        (
            "layer",
            if series.expansion().is_tabulated() {
                format!("{layer}; term n is to be multiplied by its coefficient of z")
            } else {
                format!(
                    "{layer}; term n is ifft2((i z_max (h - origin))^n / n!), to be multiplied by (z/z_max)^n"
                )
            },
        ),
    ]);
    (names.iter().map(|s| (*s).to_owned()).collect(), axes)
}

fn coefficients(spec: &CoefficientsSpec) -> Words {
    let channels = [0, 1, 2, 3].map(|c| format!("coefficient of term 4 row + {c}"));
    let (last, z_max) = (spec.columns() - 1, spec.z_max());
    let between = if spec.nearest() { "take the nearest" } else { "linear between" };
    let column = format!("z = (index/{last} - 1)·{z_max} per µm, z = 2π w/wavelength; {between}");
    let axes = BTreeMap::from([("column", column), ("row", "four terms each".to_owned())]);
    (channels.to_vec(), axes)
}

fn nodes([min_nm, max_nm]: [f64; 2]) -> Words {
    let channels = ["X weight", "Y weight", "Z weight", "wavelength in µm"];
    let axes = BTreeMap::from([
        ("column", format!("wavelength node, {min_nm} to {max_nm} nm")),
        ("row", row("nodes")),
    ]);
    (channels.map(str::to_owned).into(), axes)
}

fn lobes(spec: &LobesSpec) -> Words {
    let channels = ["X", "Y", "Z", "wavelength in µm"];
    let [low, high] = spec.geometry().middles(spec.nodes);
    let rows = row("nodes of broad lobes");
    let axes = BTreeMap::from([
        (
            "column",
            format!(
                "centre of the lobe, in equal steps from {low} to {high} per µm; in row 0, the node"
            ),
        ),
        (
            "row",
            format!(
                "{rows}; from 2: narrow lobes divided by their width, in equal steps of the width from 0 to the broadest; then the same rows for their second halves"
            ),
        ),
    ]);
    (channels.map(str::to_owned).into(), axes)
}

fn levels([min_nm, max_nm]: [f64; 2]) -> Words {
    let channels = ["X weight", "Y weight", "Z weight", "wavelength in µm, 0 after the last node"];
    let column = format!("wavelength node, {max_nm} to {min_nm} nm");
    let level = format!(
        "the nodes for |(u, v)| below 2/{NODE_LEVELS}; from 2: the nodes of the next levels, of the same width"
    );
    let axes = BTreeMap::from([("column", column), ("row", row(&level))]);
    (channels.map(str::to_owned).into(), axes)
}

fn colours(channels: usize, axes: &BakedAxes) -> Words {
    let names = ["X", "Y", "Z", "unused"];
    let names = names[..channels].iter().map(|s| (*s).to_owned()).collect();
    let BakedAxes { columns, pages, levels, stretch, pace, .. } = axes;
    let page = axes.page_columns();
    let w = match axes.least_w_squared {
        _ if axes.even_w => "-w/sqrt(4 - u² - v²)".to_owned(),
        0.0 => "w²/(4 - u² - v²)".to_owned(),
        least => format!("(w² - {least})/(4 - u² - v²)"),
    };
    let axes = BTreeMap::from([
        (
            "column",
            format!(
                "angle of (u, v): index + {page}·page = {columns}/8·(octant + p), where p = t (1.35 - 0.35 t), or 1 minus that in octants that run backwards, and t is the smaller of |u| and |v| divided by the larger; the last column of a page repeats the first of the next page"
            ),
        ),
        ("row", format!("{pace} asinh({stretch} |(u, v)|)")),
        (
            "layer",
            format!(
                "{levels}·page + {} {w}, for {pages} pages counted from 0; linear between",
                levels - 1
            ),
        ),
    ]);
    (names, axes)
}

/// The tables of wider lobes, one after the other: the axes of each as those of the narrowest.
fn wide(channels: usize, spec: &WideSpec) -> Words {
    let mut all = (Vec::new(), BTreeMap::new());
    for (index, level) in spec.wide.levels.iter().enumerate() {
        let ([left, top], [columns, rows]) = (level.place, level.size());
        let (names, axes) = colours(channels, &BakedAxes { pages: 1, ..level.axes });
        let pages = level.axes.pages;
        let head = format!(
            "level {}, lobes of a coherence length of {} µm with the peak 1, in columns from {left} to {} and rows from {top} to {}, {pages} pages of {} rows below one another: ",
            index + 1,
            level.window.coherence_um,
            left + columns - 1,
            top + rows - 1,
            level.axes.rows
        );
        all.0 = names;
        for (axis, meaning) in axes {
            let text: &mut String = all.1.entry(axis).or_default();
            if !text.is_empty() {
                text.push_str("; ");
            }
            *text += &format!("{head}{meaning}");
        }
    }
    all
}

fn spreads() -> Words {
    let channels = [
        format!("first column + {PACKED}·number of rows of a page"),
        "first row".to_owned(),
        format!("columns of a page, without the repeated one + {PACKED}·number of pages"),
        "factor of |(u, v)| in the argument of asinh".to_owned(),
    ];
    let column = "level of wider lobes, from 1; the last column has the reflectance at normal incidence in its first channel";
    let axes = BTreeMap::from([("column", column.to_owned()), ("row", row("the level's sizes"))]);
    (channels.to_vec(), axes)
}

fn rotation() -> Words {
    let axes = [("column", "one".to_owned()), ("row", row("unused"))];
    (vec!["unused".to_owned(); 4], BTreeMap::from(axes))
}

fn grating() -> Words {
    let channels = ["period along x in µm", "period along y in µm", "unused", "unused"];
    let axes = BTreeMap::from([
        ("column", "one".to_owned()),
        ("row", row("the surface's strongest period as a vector, from one groove to the next")),
    ]);
    (channels.map(str::to_owned).into(), axes)
}

fn efficiencies(axes: &EfficiencyAxes) -> Words {
    let channels = [
        "efficiency at the left edge of the column",
        "its slope there, per column",
        "efficiency at the right edge",
        "its slope there, per column",
    ];
    let Bins { r_max, s_max } = axes.bins;
    let EfficiencyAxes { columns, min_um, .. } = axes;
    let column = format!(
        "-w/wavelength from index to index + 1, in units of {}/{columns} per µm; cubic between the edges",
        2.0 / min_um
    );
    let row = format!("order (r, s): (s + {s_max})·{} + r + {r_max}", 2 * r_max + 1);
    let axes = BTreeMap::from([("column", column), ("row", row)]);
    (channels.map(str::to_owned).into(), axes)
}

fn moments(range_nm: [f64; 2]) -> Words {
    let channels = [0, 1, 2, 3].map(|p| {
        format!(
            "integral of t^{p} times the colour weight, t = (wavelength - {CENTRE_NM} nm)/{UNIT_NM} nm"
        )
    });
    let [min_nm, max_nm] = range_nm;
    let column = format!(
        "integral from {min_nm} nm to {min_nm} + index·{} nm",
        (max_nm - min_nm) / (moment_columns(range_nm) - 1) as f64
    );
    let row = "X, Y, Z of white light; 3: X, Y, Z between a column and the next; from 4, from 8: the same of the red and of the green share of white light";
    let axes = BTreeMap::from([("column", column), ("row", row.to_owned())]);
    (channels.to_vec(), axes)
}

fn streaks() -> Words {
    let channels = [
        "X of red, green or blue light about the cell's wavelength".to_owned(),
        "Y".to_owned(),
        "Z".to_owned(),
        "row 0: wavelength of the cell, µm; row 1: its lower edge, µm; row 2: standard deviation to blur over, µm of wavelength".to_owned(),
    ];
    let column = "cells from short wavelengths to long ones, then the upper edge of the last; after that the same with twice as many cells";
    let row = "red, green, blue light";
    (channels.to_vec(), BTreeMap::from([("column", column.to_owned()), ("row", row.to_owned())]))
}

fn order_paths(of: &OrderPaths) -> Words {
    let channels = [
        "row 0: threshold of the alias table; row 1: probability of all shorter wavelengths; row 2: probability of the cell of wavelengths that begins here",
        "row 0: the other order, as a column; row 1: X; row 2: share of red light",
        "row 0: probability of the order; row 1: Y; row 2: share of green light",
        "row 1: Z; row 2: share of blue light",
    ];
    let Bins { r_max, s_max } = of.bins;
    let [min_nm, max_nm] = of.range_nm;
    let column = format!(
        "row 0: order (r, s): (s + {s_max})·{} + r + {r_max}; rows 1 and 2: {min_nm} nm + index·{} nm",
        2 * r_max + 1,
        (max_nm - min_nm) / wavelength_cells(of.range_nm) as f64
    );
    let row = "orders; wavelengths, X, Y, Z times the width of a cell; wavelengths";
    let axes = BTreeMap::from([("column", column), ("row", row.to_owned())]);
    (channels.map(str::to_owned).into(), axes)
}

fn colour_paths() -> Words {
    let channels = [
        "0: the angle of (u, v) is divided; 1: the radius",
        "place of the division: share of a turn from -u, or |(u, v)|²/4",
        "probability of the half below",
        "",
    ];
    let columns = path_columns();
    let column = format!(
        "node of a binary tree from 1 on, modulo {columns}; halves of node n: 2n and 2n + 1"
    );
    let row = format!("node divided by {columns}");
    let axes = BTreeMap::from([("column", column), ("row", row)]);
    (channels.map(str::to_owned).into(), axes)
}

fn cells() -> Words {
    let channels = [
        "row 0: u of the centroid; else X",
        "row 0: v of the centroid; else Y",
        "row 0: standard deviation of the cell's light on each axis, in direction cosines; else Z",
        "",
    ];
    let row = "0: the cell; 1 + 3 i + j: layer i of w, light of colour j (red, green, blue)";
    let axes = BTreeMap::from([("column", "cell of (u, v)".to_owned()), ("row", row.to_owned())]);
    (channels.map(str::to_owned).into(), axes)
}

fn row(first: &str) -> String {
    format!(
        "0: {first}; 1: the first texel has the cosine and sine of the surface's rotation, the scale of the first term, and the ratio of the scales of successive terms"
    )
}
