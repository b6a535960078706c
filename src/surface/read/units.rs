//! Checks and applies the plan's keys for a file: scale and height.

use std::fmt;

use crate::error::{Error, Result};
use crate::plan::FileSource;
use crate::surface::raster::{Raster, Samples};
use crate::surface::{MAX_HEIGHT_UM, MAX_PITCH_UM, MAX_SIDE, MIN_PITCH_UM, check_pixel, check_um};

/// Checks the keys as far as that does not need the file.
pub(super) fn check_keys(source: &FileSource, subject: &str) -> Result<()> {
    let check = |key: &str, value: Option<f64>, max: f64| {
        value.map_or(Ok(()), |v| check_um(subject, key, v, max))
    };
    check("size_um", source.size_um, MAX_SIDE as f64 * MAX_PITCH_UM)?;
    check("pixel_um", source.pixel_um, MAX_PITCH_UM)?;
    check("height_um", source.height_um, MAX_HEIGHT_UM)?;
    // the largest unit of heights in files is the metre
    check("z_unit_um", source.z_unit_um, 1e6)?;
    if let (Some(size), Some(pixel)) = (source.size_um, source.pixel_um) {
        let cause = format!("both `size_um = {size}` and `pixel_um = {pixel}` are given");
        return Err(Error::new(subject, cause).remedy("remove one of them"));
    }
    Ok(())
}

/// Pixel pitch along x and y, µm.
pub(super) fn pitch(
    source: &FileSource,
    raster: &Raster,
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<(f64, f64)> {
    // for a profile, the size is its length, whether it is a row or a column
    let along = if raster.columns == 1 { raster.rows } else { raster.columns };
    let aspect = raster.scale.map_or(1.0, |(x, y)| y / x);
    let given = match (source.size_um, source.pixel_um) {
        (Some(size), _) if raster.columns == 1 => Some((
            format!("`size_um = {size}` over {along} pixels"),
            size / along as f64 / aspect,
            aspect,
        )),
        (Some(size), _) => {
            Some((format!("`size_um = {size}` over {along} pixels"), size / along as f64, aspect))
        }
        (None, Some(pixel)) => Some((format!("`pixel_um = {pixel}`"), pixel, 1.0)),
        (None, None) => None,
    };
    let (origin, x, y) = match (given, raster.scale) {
        (Some((origin, x, aspect)), _) => (origin, x, x * aspect),
        (None, Some((x, y))) => ("the file's own scale".to_owned(), x, y),
        (None, None) => {
            return Err(Error::new(subject, "has no physical scale: neither `size_um` nor `pixel_um` is given")
                .remedy("add `size_um` (width of the patch in µm) or `pixel_um` (pitch of the pixels in µm)"));
        }
    };
    for pitch_um in [x, y] {
        check_pixel(subject, &origin, pitch_um)?;
    }
    let differs = |a: f64, b: f64| (a - b).abs() > 1e-6 * b;
    if let Some((file_x, file_y)) = raster.scale
        && (differs(x, file_x) || differs(y, file_y))
    {
        notes.push(format!(
            "{origin} overrides the file's own pitch, {file_x} × {file_y} µm, with {x} × {y} µm"
        ));
    }
    Ok((x, y))
}

/// How an integer file quantises its heights.
pub(super) struct Steps {
    /// µm from one height to the next.
    pub(super) size_um: f64,
    bits: u8,
    /// Grey levels per step. Above 1 if the file has more bits than the data.
    levels: u32,
}

impl fmt::Display for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nm = self.size_um * 1e3;
        // three significant digits, since a 16-bit step is a few thousandths of a nanometre
        let digits = (2.0 - nm.log10().floor()).clamp(0.0, 9.0) as usize;
        write!(f, "heights come in steps of {nm:.digits$} nm ({}-bit grey", self.bits)?;
        match self.levels {
            1 => f.write_str(")"),
            levels => write!(f, ", of which only every {levels}th level is used)"),
        }
    }
}

/// The steps of an integer file whose height is known. Floats have no steps.
pub(super) fn steps(source: &FileSource, samples: &Samples) -> Option<Steps> {
    let (Samples::Grey { shares, bits }, Some(height_um)) = (samples, source.height_um) else {
        return None;
    };
    let top = f64::from((1u32 << bits) - 1);
    let mut greys = shares.iter().filter(|share| !share.is_nan()).map(|s| (s * top).round() as u32);
    let first = greys.next()?;
    let common = greys.map(|grey| grey.abs_diff(first)).fold(0, greatest_common_divisor);
    // a flat surface has only one level, so the step is unknown
    let levels = common.max(1);
    Some(Steps { size_um: height_um * f64::from(levels) / top, bits: *bits, levels })
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// Converts samples to µm, with the checks that need the samples.
pub(super) fn heights(
    source: &FileSource,
    samples: Samples,
    columns: usize,
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<Vec<f64>> {
    let error = |cause: String| Error::new(subject, cause);
    let (mut values, unit_um, what) = match samples {
        Samples::Grey { shares, bits } => {
            let top = (1u32 << bits) - 1;
            if let Some(unit) = source.z_unit_um {
                return Err(error(format!(
                    "`z_unit_um = {unit}` is for float files, but this file has {bits}-bit integers"
                ))
                .remedy(format!("give `height_um`, the height of the full grey range 0…{top}")));
            }
            let height_um = source.height_um.ok_or_else(|| {
                error(format!("`height_um` is missing: the file has {bits}-bit integers without a unit"))
                    .remedy(format!("give the height in µm of the full grey range 0…{top}, not of the image's extrema"))
            })?;
            (shares, height_um, format!("`height_um = {height_um}`"))
        }
        Samples::Float { values, unit_um, needs_unit } => {
            if let Some(height) = source.height_um {
                let cause = format!(
                    "`height_um = {height}` is for integer files, but this file has floats, which are heights in µm"
                );
                return Err(error(cause)
                    .remedy("remove `height_um`; if the numbers are not in µm, set `z_unit_um`"));
            }
            if needs_unit && source.z_unit_um.is_none() {
                return Err(error("the unit of the file's heights is not a unit of length".into())
                    .remedy("give `z_unit_um`, the µm per unit"));
            }
            if let (Some(plan), Some(file)) = (source.z_unit_um, unit_um)
                && plan != file
            {
                notes.push(format!(
                    "`z_unit_um = {plan}` overrides the file's own unit of {file} µm"
                ));
            }
            let unit = source.z_unit_um.or(unit_um).unwrap_or(1.0);
            (values, unit, format!("with {unit} µm per unit"))
        }
    };
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (i, v) in values.iter_mut().enumerate() {
        if v.is_infinite() {
            return Err(error(format!(
                "the height at column {}, row {} is {v}",
                i % columns,
                i / columns
            ))
            .remedy("write NaN for void pixels"));
        }
        *v *= unit_um;
        (low, high) = (low.min(*v), high.max(*v));
    }
    let range = high - low;
    if range > MAX_HEIGHT_UM {
        return Err(error(format!(
            "heights from {low} to {high} µm ({what}) span more than {MAX_HEIGHT_UM} µm"
        ))
        .remedy("if the numbers are in nm, set `z_unit_um = 0.001`"));
    }
    if range > 0.0 && range < MIN_PITCH_UM {
        notes.push(format!("the heights span only {range:e} µm, less than an atom; if they are in metres, set `z_unit_um = 1e6`"));
    }
    Ok(values)
}
