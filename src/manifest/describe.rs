//! What the numbers of a table mean.

use std::collections::BTreeMap;

use crate::bake::COLOUR_SCALE;
use crate::plan::{Container, Mode, Variant};
use crate::resolve::{Axes, Lobes, NODE_LEVELS, Resolved};
use crate::tables::container::entry;
use crate::tables::{Scale, TERMS, Table};
use crate::template::GENERATED;

use super::{SCHEMA_VERSION, TableDescription};

/// The description of a table.
pub fn describe(
    table: &Table,
    id: &str,
    resolved: &Resolved,
    variant: &Variant,
    containers: &[Container],
) -> TableDescription {
    let shape = table.shape();
    let dimension = if table.layers == 0 { "2d" } else { "2d-array" };
    let (channels, axes) = match table.name {
        "terms" => terms_meaning(table, resolved),
        "coefficients" => coefficients_meaning(table, resolved),
        "colours" => colours_meaning(table, &resolved.axes),
        _ if variant.mode == Mode::Baked => rotation_meaning(),
        _ if variant.mode == Mode::Gems => grating_meaning(),
        _ if !resolved.node_counts.is_empty() => levels_meaning(variant),
        _ => spectrum_meaning(variant, resolved),
    };
    let has_scales = table.binding == TERMS && resolved.scale != Scale::NONE;
    let term_scales = if has_scales {
        (0..resolved.expansion.terms as usize).map(|n| resolved.scale.of(n)).collect()
    } else {
        Vec::new()
    };
    TableDescription {
        generated_by: GENERATED,
        schema_version: SCHEMA_VERSION,
        id: id.to_owned(),
        data: format!("{id}.bin"),
        bytes: table.byte_count(),
        format: table.format.name(),
        endianness: "little",
        dimension,
        width: table.width,
        height: table.height,
        layers: table.layers.max(1),
        order: "[layer][row][column][channel]",
        channels,
        axes,
        scale: if table.name == "colours" { 1.0 / COLOUR_SCALE } else { 1.0 },
        term_scales,
        wrap: "none: no texel outside is read",
        containers: containers.iter().map(|&c| (c, entry(c, &shape, id))).collect(),
    }
}

fn terms_meaning(
    table: &Table,
    resolved: &Resolved,
) -> (Vec<String>, BTreeMap<&'static str, String>) {
    let paired = table.format.channels() == 4;
    let names: &[&str] = if paired {
        &["re, even term", "im, even term", "re, odd term", "im, odd term"]
    } else {
        &["re", "im"]
    };
    let layer = if paired { "layer p holds terms 2p and 2p+1" } else { "layer n holds term n" };
    let (x, y) = (resolved.bins.r_max, resolved.bins.s_max);
    let size_um = resolved.grid.map_or(resolved.patch_um, |grid| grid.size_um);
    let bin = |axis: &str, centre: usize, l: f64| match resolved.grid {
        None => format!("bin {axis} = index - {centre}, frequency bin/{l} cycles per µm"),
        Some(_) => format!(
            "frequency (index - {centre})/{l} cycles per µm, linear between; the coherence window is in it"
        ),
    };
    let axes = BTreeMap::from([
        ("column", bin("r", x, size_um[0])),
        ("row", bin("s", y, size_um[1])),
        (
            "layer",
            if resolved.expansion.is_tabulated() {
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

fn coefficients_meaning(
    table: &Table,
    resolved: &Resolved,
) -> (Vec<String>, BTreeMap<&'static str, String>) {
    let channels = [0, 1, 2, 3].map(|c| format!("coefficient of term 4 row + {c}"));
    let (last, z_max) = (table.width - 1, resolved.expansion.z_max);
    let between = if resolved.grid.is_some() { "the nearest counts" } else { "linear between" };
    let column = format!("z = (index/{last} - 1)·{z_max} per µm, z = 2π w/wavelength; {between}");
    let axes = BTreeMap::from([("column", column), ("row", "four terms each".to_owned())]);
    (channels.to_vec(), axes)
}

fn spectrum_meaning(
    variant: &Variant,
    resolved: &Resolved,
) -> (Vec<String>, BTreeMap<&'static str, String>) {
    let w = &variant.wavelengths;
    let adaptive = variant.mode == Mode::Adaptive && w.max_nm > w.min_nm;
    let (weights, column, row) = if adaptive {
        let [low, high] = Lobes::new(variant, resolved.patch_um).middles(resolved.corridor.nodes);
        let rows = row_meaning("nodes of broad lobes");
        (
            ["X", "Y", "Z"],
            format!("middle of the lobe, equal steps from {low} to {high} per µm; of row 0, node"),
            format!(
                "{rows}; from 2: lobes over their width, from 0 to the broadest in equal steps, then their second halves"
            ),
        )
    } else {
        (
            ["X weight", "Y weight", "Z weight"],
            format!("wavelength node, {} to {} nm", w.min_nm, w.max_nm),
            row_meaning("nodes"),
        )
    };
    let mut channels = weights.map(str::to_owned).to_vec();
    channels.push("wavelength in µm".to_owned());
    (channels, BTreeMap::from([("column", column), ("row", row)]))
}

fn levels_meaning(variant: &Variant) -> (Vec<String>, BTreeMap<&'static str, String>) {
    let w = &variant.wavelengths;
    let channels = ["X weight", "Y weight", "Z weight", "wavelength in µm, 0 after the last node"];
    let column = format!("wavelength node, {} to {} nm", w.max_nm, w.min_nm);
    let level = format!(
        "the nodes of |(u, v)| below 2/{NODE_LEVELS}; row 2 on: those of the next levels, each as wide"
    );
    let axes = BTreeMap::from([("column", column), ("row", row_meaning(&level))]);
    (channels.map(str::to_owned).into(), axes)
}

fn colours_meaning(table: &Table, axes: &Axes) -> (Vec<String>, BTreeMap<&'static str, String>) {
    let names = ["X", "Y", "Z", "unused"];
    let names = names[..table.format.channels()].iter().map(|s| (*s).to_owned()).collect();
    let Axes { columns, pages, levels, stretch, pace, .. } = axes;
    let page = axes.page_columns();
    let axes = BTreeMap::from([
        (
            "column",
            format!(
                "angle of (u, v): index + {page} times the page is {columns}/8 times the octant and t (1.35 - 0.35 t), t the smaller over the larger of |u| and |v| (or 1 minus that, where the octant runs back); the last column repeats the first of the next page"
            ),
        ),
        ("row", format!("{pace} asinh({stretch} |(u, v)|)")),
        (
            "layer",
            format!(
                "{levels} times the page, of {pages}, plus {} w²/(4 - u² - v²); linear between",
                levels - 1
            ),
        ),
    ]);
    (names, axes)
}

fn rotation_meaning() -> (Vec<String>, BTreeMap<&'static str, String>) {
    let axes = [("column", "one".to_owned()), ("row", row_meaning("unused"))];
    (vec!["unused".to_owned(); 4], BTreeMap::from(axes))
}

fn grating_meaning() -> (Vec<String>, BTreeMap<&'static str, String>) {
    let channels = ["period along x in µm", "period along y in µm", "unused", "unused"];
    let axes = BTreeMap::from([
        ("column", "one".to_owned()),
        (
            "row",
            row_meaning("the surface's strongest period as a vector, from one groove to the next"),
        ),
    ]);
    (channels.map(str::to_owned).into(), axes)
}

fn row_meaning(first: &str) -> String {
    format!(
        "0: {first}; 1: first texel holds cosine and sine of the surface's rotation, scale of the first term, ratio of the scales of successive terms"
    )
}
