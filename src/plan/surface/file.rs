//! The keys of a surface with a file.

use std::path::Path;

use crate::plan::item::{Item, Table};
use crate::plan::{FileSource, Flip, Trust, VoidValue, words};

/// The keys that only a surface with a file has.
pub(super) const KEYS: [&str; 10] = [
    "size_um",
    "size_y_um",
    "pixel_um",
    "height_um",
    "z_unit_um",
    "resample_um",
    "void_value",
    "channel",
    "flip",
    "trust",
];

/// Pairs of keys that cannot both be given, with cause and remedy.
const EXCLUDES: [(&str, &str, &str, &str); 3] = [
    ("size_um", "pixel_um", "size_um and pixel_um both set the scale", "remove one of them"),
    (
        "size_y_um",
        "pixel_um",
        "size_y_um and pixel_um both set the scale along y",
        "remove pixel_um, and give size_um for the scale along x",
    ),
    (
        "height_um",
        "z_unit_um",
        "height_um and z_unit_um both set the heights",
        "keep height_um for integer files, z_unit_um for float files",
    ),
];

/// Reads the keys. `limit_um`: the maximum pitch that resolves all orders.
pub(super) fn read(table: &Table, item: &Item, folder: &Path, limit_um: f64) -> Option<FileSource> {
    let path = item.string("the path of a height field, relative to the plan")?;
    if path.is_empty() || path.contains('\0') {
        item.fail("is not a valid path", "give the path of a height field, relative to the plan");
        return None;
    }
    if let Some(control) = path.chars().find(|c| c.is_control()) {
        let cause = format!(
            "contains the control character U+{:04X}: in a TOML string between \" a backslash begins an escape",
            u32::from(control)
        );
        item.fail(cause, "write / in place of \\, or put the path between ' '");
        return None;
    }
    for (one, other, cause, remedy) in EXCLUDES {
        if let (Some(_), Some(other)) = (table.get(one), table.get(other)) {
            other.fail(cause, remedy);
            return None;
        }
    }
    let length = |key: &str, what: &str| match table.get(key) {
        Some(item) => item.positive(what).map(Some),
        None => Some(None),
    };
    let source = FileSource {
        path: folder.join(path),
        size_um: length("size_um", "the width of the patch in µm")?,
        size_y_um: length("size_y_um", "the length of the patch along y in µm")?,
        pixel_um: length("pixel_um", "the pixel pitch in µm")?,
        height_um: length("height_um", "a height in µm")?,
        z_unit_um: length("z_unit_um", "µm per unit of the file")?,
        resample_um: length("resample_um", "the pitch after resampling in µm")?,
        channel: table.get("channel").map_or(Some(None), |item| channel(&item).map(Some))?,
        void_value: table.get("void_value").map_or(Some(None), |item| void(&item).map(Some))?,
        flip: table.get("flip").map_or(Some(Flip::None), |item| item.word(words::FLIPS))?,
        trust: table.get("trust").map_or(Some(Trust::File), |item| item.word(words::TRUSTS))?,
    };
    resolves(table, &source, limit_um).then_some(source)
}

/// A channel's name, or its number from 1.
fn channel(item: &Item) -> Option<String> {
    if item.is_integer() {
        return item.whole(1..10_000, "the number of the channel").map(|n| n.to_string());
    }
    let name = item.string("the name or the number of a channel")?;
    if name.trim().is_empty() {
        item.fail("is empty", "give the name or the number of a channel");
        return None;
    }
    Some(name.to_owned())
}

fn void(item: &Item) -> Option<VoidValue> {
    if item.as_str().is_some() {
        return item.word(words::VOIDS);
    }
    let what = "the number that stands for void pixels, or \"none\"";
    item.number("finite", what, |_| true).map(VoidValue::Number)
}

/// Checks the pitch, as far as that does not need the file.
fn resolves(table: &Table, source: &FileSource, limit_um: f64) -> bool {
    let (key, pitch_um) = match (source.resample_um, source.pixel_um) {
        (Some(pitch), _) => ("resample_um", pitch),
        (None, Some(pitch)) => ("pixel_um", pitch),
        (None, None) => return true,
    };
    if !super::too_coarse(pitch_um, limit_um) {
        return true;
    }
    if let Some(item) = table.get(key) {
        let cause = format!(
            "a pitch above a quarter of the shortest wavelength, {limit_um} µm along x and y, cannot resolve all orders"
        );
        let remedy = format!(
            "scan with a pitch of at most {limit_um} µm, add resample_um = {limit_um} (nothing finer than the scan is then known), or use wavelengths of at least {:.0} nm",
            (pitch_um * 4000.0).ceil()
        );
        item.fail(cause, remedy);
    }
    false
}
