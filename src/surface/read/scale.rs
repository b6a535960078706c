//! The pitch of pixels: what the plan says against what the file says.

use crate::error::{Error, Result};
use crate::plan::{FileSource, Trust};
use crate::surface::length::{differs, name, shown};
use crate::surface::raster::{Lateral, Stated};
use crate::surface::{MAX_PITCH_UM, MAX_SIDE, check_pixel, check_um};

/// Units that are tried where a file writes lengths without one, as µm.
const COMMON: [f64; 6] = [1.0, 1e-3, 1e3, 1e6, 1e-4, 1e4];

/// Checks the keys of the scale as far as that does not need the file.
pub(super) fn check_keys(source: &FileSource, subject: &str) -> Result<()> {
    let FileSource { size_um, size_y_um, pixel_um, resample_um, .. } = *source;
    for (key, value, max) in [
        ("size_um", size_um, MAX_SIDE as f64 * MAX_PITCH_UM),
        ("size_y_um", size_y_um, MAX_SIDE as f64 * MAX_PITCH_UM),
        ("pixel_um", pixel_um, MAX_PITCH_UM),
        ("resample_um", resample_um, MAX_PITCH_UM),
    ] {
        value.map_or(Ok(()), |v| check_um(subject, key, v, max))?;
    }
    for (key, size) in [("size_um", size_um), ("size_y_um", size_y_um)] {
        if let (Some(size), Some(pixel)) = (size, pixel_um) {
            let cause = format!("both `{key} = {size}` and `pixel_um = {pixel}` are given");
            return Err(Error::new(subject, cause).remedy("remove one of them"));
        }
    }
    Ok(())
}

/// What a caller knows of a file when its scale is decided.
pub(super) struct Shape<'a> {
    pub columns: usize,
    pub rows: usize,
    pub stated: &'a Stated,
    /// µm per unit of the heights.
    pub unit_um: f64,
}

/// Pixel pitch along x and y, µm.
///
/// The plan's numbers, or the file's where the plan has none. An error if they contradict each other, unless the plan
/// is trusted. Pixels are square unless plan or file give both axes.
pub(super) fn pitch(
    source: &FileSource,
    shape: &Shape,
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<(f64, f64)> {
    let &Shape { columns, rows, stated, .. } = shape;
    if let (Some(size), 1) = (source.size_y_um, columns.min(rows)) {
        let cause = format!("`size_y_um = {size}` is for two axes, but the file is a profile");
        return Err(Error::new(subject, cause).remedy("give its length as `size_um`"));
    }
    let by_file = of_file(source, shape, subject, notes)?;
    let planned = of_plan(source, [columns, rows], by_file);
    let (origin, [x, y]) = match (planned, by_file) {
        (Some(planned), _) => planned,
        (None, Some(pitch)) => (format!("the file ({})", stated.pitch_by), pitch),
        (None, None) => return Err(no_scale(shape, subject)),
    };
    for pitch_um in [x, y] {
        check_pixel(subject, &origin, pitch_um)?;
    }
    let Some(file) = by_file else { return Ok((x, y)) };
    // of a profile, only the pitch along it counts
    let wrong = [(x, file[0], columns), (y, file[1], rows)]
        .into_iter()
        .any(|(plan, file, pixels)| (pixels > 1 || columns == rows) && differs(plan, file));
    if !wrong {
        return Ok((x, y));
    }
    let by = &stated.pitch_by;
    let pair = |[x, y]: [f64; 2]| format!("{} × {} µm", shown(x), shown(y));
    let sizes = |[x, y]: [f64; 2]| pair([x * columns as f64, y * rows as f64]);
    if source.trust == Trust::Plan {
        notes.push(format!(
            "trust = \"plan\": {origin} makes pixels {}, although the file states {} ({by})",
            pair([x, y]),
            pair(file)
        ));
        return Ok((x, y));
    }
    let cause = format!(
        "{origin} makes the patch {} with pixels of {}, but the file states {} with pixels of {} ({by})",
        sizes([x, y]),
        pair([x, y]),
        sizes(file),
        pair(file)
    );
    let remedy = "remove the plan's key to use the file's scale, or add `trust = \"plan\"` to use the plan's";
    Err(Error::new(subject, cause).remedy(remedy))
}

/// What the file states, in µm.
fn of_file(
    source: &FileSource,
    shape: &Shape,
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<Option<[f64; 2]>> {
    let Some(raw) = shape.stated.both() else { return Ok(None) };
    let um = |unit: f64| raw.map(|pitch| pitch * unit);
    let by = &shape.stated.pitch_by;
    if let Lateral::Um(unit) = shape.stated.lateral {
        return Ok(Some(um(unit)));
    }
    let likely = shape.stated.lateral == Lateral::LikeHeights;
    let Some((origin, planned)) = of_plan(source, [shape.columns, shape.rows], Some(raw)) else {
        if !likely {
            return Ok(None);
        }
        let unit =
            name(shape.unit_um).map_or_else(|| format!("{} µm", shape.unit_um), str::to_owned);
        notes.push(format!(
            "{by}: no unit stated, taken as {unit} like the heights; `pixel_um` or `size_um` says otherwise"
        ));
        return Ok(Some(um(shape.unit_um)));
    };
    // along the axis with pixels; of a profile the other one means nothing
    let axis = usize::from(shape.columns == 1);
    let agrees = |unit: &f64| !differs(raw[axis] * unit, planned[axis]);
    match std::iter::once(shape.unit_um).filter(|_| likely).chain(COMMON).find(agrees) {
        Some(unit) => {
            let unit_name = name(unit).map_or_else(|| format!("{unit} µm"), str::to_owned);
            notes.push(format!("{by}: no unit stated, taken as {unit_name}, as {origin} says"));
            Ok(Some(um(unit)))
        }
        None if source.trust == Trust::Plan => {
            notes.push(format!(
                "trust = \"plan\": {origin} is used; {by} ({} per pixel, no unit) agrees with it in no common unit",
                shown(raw[axis])
            ));
            Ok(None)
        }
        None => {
            let cause = format!(
                "{origin} makes pixels {} µm, but {by} gives {} per pixel without a unit, which is that in neither m, mm, µm, nm nor Å",
                shown(planned[axis]),
                shown(raw[axis])
            );
            Err(Error::new(subject, cause)
                .remedy("correct the key, or add `trust = \"plan\"` to use the plan's scale"))
        }
    }
}

/// What the plan says: the keys in words, and the pitch along x and y. `file`: the pitches of the file, whose ratio fills
/// in an axis that the plan leaves out.
fn of_plan(
    source: &FileSource,
    [columns, rows]: [usize; 2],
    file: Option<[f64; 2]>,
) -> Option<(String, [f64; 2])> {
    let aspect = file.map_or(1.0, |[x, y]| y / x);
    let along = if columns == 1 { rows } else { columns };
    let over =
        |key: &str, size: f64, pixels: usize| format!("`{key} = {size}` over {pixels} pixels");
    match (source.size_um, source.size_y_um, source.pixel_um) {
        (Some(x), Some(y), _) => Some((
            format!("`size_um = {x}` and `size_y_um = {y}`"),
            [x / columns as f64, y / rows as f64],
        )),
        // of a profile, the size is its length, whether it is a row or a column
        (Some(size), None, _) => {
            let pitch = size / along as f64;
            let x = if columns == 1 { pitch / aspect } else { pitch };
            Some((over("size_um", size, along), [x, x * aspect]))
        }
        (None, Some(size), _) => {
            let y = size / rows as f64;
            Some((over("size_y_um", size, rows), [y / aspect, y]))
        }
        (None, None, Some(pixel)) => Some((format!("`pixel_um = {pixel}`"), [pixel; 2])),
        (None, None, None) => None,
    }
}

fn no_scale(shape: &Shape, subject: &str) -> Error {
    let by = &shape.stated.pitch_by;
    let cause = match shape.stated.both() {
        Some([x, y]) if !by.is_empty() => format!(
            "has no physical scale: {by} gives pixels of {} × {} without a unit",
            shown(x),
            shown(y)
        ),
        _ => "has no physical scale: neither `size_um` nor `pixel_um` is given, and the file states none"
            .to_owned(),
    };
    Error::new(subject, cause).remedy(
        "add `size_um` (width of the patch in µm) or `pixel_um` (pitch of the pixels in µm)",
    )
}
