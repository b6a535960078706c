//! Gwyddion Simple Field, the only open format of scans that contains its own scale.
//!
//! Source: the format's description in the Gwyddion user guide, appendix "Gwyddion Simple Field". A magic line, header
//! lines `Key = Value`, one to four NUL bytes up to a multiple of four, then `YRes` rows of `XRes` little-endian `f32`, the
//! top row first. `XReal` and `YReal` are the size of the whole field, in base SI units.

use crate::error::{Error, Result};
use crate::surface::HeightField;
use crate::surface::length::{Unit, unit};
use crate::surface::raster::{Raster, Samples, Stated};

/// The first line of every file.
pub(super) const MAGIC: &[u8] = b"Gwyddion Simple Field 1.0\n";

/// Maximum length of the header, in bytes.
const MAX_HEADER: usize = 1 << 16;
/// Remedy of errors in the header.
const HEADER: &str = "correct the header, or export the file again";

/// A field as a GSF file: lengths and heights in metres, heights rounded to `f32`.
pub fn write_gsf(field: &HeightField) -> Vec<u8> {
    let metres = 1e-6;
    let mut bytes = MAGIC.to_vec();
    let header = format!(
        "XRes = {}\nYRes = {}\nXReal = {:e}\nYReal = {:e}\nXYUnits = m\nZUnits = m\n",
        field.columns(),
        field.rows(),
        field.size_x_um() * metres,
        field.size_y_um() * metres
    );
    bytes.extend_from_slice(header.as_bytes());
    bytes.resize(bytes.len() / 4 * 4 + 4, 0);
    for h in field.heights_um() {
        bytes.extend_from_slice(&((h * metres) as f32).to_le_bytes());
    }
    bytes
}

/// Reads a file whose magic line has been seen.
///
/// If `XYUnits` or `ZUnits` is missing, metres are assumed. If only one of the two sizes is given, pixels are square.
/// For units that are not a power of ten of the metre, the plan must give the scale or the unit of heights.
pub(super) fn read(bytes: &[u8], subject: &str) -> Result<Raster> {
    let error = |cause: String| Error::new(subject, cause);
    let body = &bytes[MAGIC.len()..];
    let end = body.iter().take(MAX_HEADER).position(|&b| b == 0).ok_or_else(|| {
        error("the GSF header does not end in a NUL byte".into())
            .remedy("the file is truncated or not a GSF file; export it again")
    })?;
    let header = std::str::from_utf8(&body[..end])
        .map_err(|e| error("the GSF header is not UTF-8".into()).source(e).remedy(HEADER))?;
    let mut fields = Header::default();
    for (number, line) in header.lines().enumerate() {
        fields
            .line(line)
            .map_err(|cause| error(format!("line {}: {cause}", number + 2)).remedy(HEADER))?;
    }
    let missing = |key: &str| error(format!("the GSF header has no `{key}`")).remedy(HEADER);
    let (x_res, y_res) = (
        fields.x_res.ok_or_else(|| missing("XRes"))?,
        fields.y_res.ok_or_else(|| missing("YRes"))?,
    );
    let (columns, rows) = super::check_pixels(subject, x_res, y_res)?;

    let start = (MAGIC.len() + end) / 4 * 4 + 4;
    let padding = bytes.get(MAGIC.len() + end..start).unwrap_or_default();
    if padding.is_empty() || padding.iter().any(|&b| b != 0) {
        return Err(error(
            "the GSF header is not padded with NUL bytes to a multiple of four".into(),
        )
        .remedy("export the file again"));
    }
    let (data, expected) = (&bytes[start..], columns * rows * 4);
    if data.len() != expected {
        let cause = format!(
            "{columns} × {rows} pixels need {expected} bytes of data, but the file has {}",
            data.len()
        );
        let remedy = if data.len() < expected {
            "the file is truncated; export it again"
        } else {
            "correct XRes or YRes"
        };
        return Err(error(cause).remedy(remedy));
    }
    let values =
        data.as_chunks::<4>().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect();

    let positive = |key: &str, value: Option<f64>| match value {
        Some(v) if !(v.is_finite() && v > 0.0) => {
            Err(error(format!("`{key} = {v}` is not positive and finite")).remedy(HEADER))
        }
        _ => Ok(value),
    };
    let sizes = [positive("XReal", fields.x_real)?, positive("YReal", fields.y_real)?];
    // metres are what the format says where it says nothing
    let of = |words: &Option<String>| unit(words.as_deref().unwrap_or("m"));
    let (lateral, heights) = (of(&fields.xy_units), of(&fields.z_units));
    let mut notes = Vec::new();
    if let (Unit::Other(words), [Some(_), _] | [_, Some(_)]) = (&lateral, sizes) {
        notes.push(format!(
            "`XYUnits = {words}` is not a unit of length, so the file's scale is not used"
        ));
    }
    if let Unit::Other(words) = &heights {
        notes.push(format!("`ZUnits = {words}` is not a unit of length, so `z_unit_um` is used"));
    }
    let mut stated =
        Stated { unit: Some(heights), heights_by: "ZUnits".to_owned(), ..Stated::default() };
    stated.sizes(sizes, [columns, rows], &lateral, "XReal, YReal");
    Ok(Raster { columns, rows, samples: Samples::Float(values), stated, notes })
}

/// The keys that are used. Titles and offsets are ignored.
#[derive(Default)]
struct Header {
    x_res: Option<u64>,
    y_res: Option<u64>,
    x_real: Option<f64>,
    y_real: Option<f64>,
    xy_units: Option<String>,
    z_units: Option<String>,
}

impl Header {
    fn line(&mut self, line: &str) -> Result<(), String> {
        if line.trim().is_empty() {
            return Ok(());
        }
        let (key, value) =
            line.split_once('=').ok_or_else(|| format!("`{}` is not `Key = Value`", clip(line)))?;
        let (key, value) = (key.trim(), value.trim());
        let whole = || {
            value
                .parse::<u64>()
                .map_err(|_| format!("`{key} = {}` is not a whole number", clip(value)))
        };
        let real = || {
            value.parse::<f64>().map_err(|_| format!("`{key} = {}` is not a number", clip(value)))
        };
        match key {
            "XRes" => self.x_res = Some(whole()?),
            "YRes" => self.y_res = Some(whole()?),
            "XReal" => self.x_real = Some(real()?),
            "YReal" => self.y_real = Some(real()?),
            "XYUnits" => self.xy_units = Some(value.to_owned()),
            "ZUnits" => self.z_units = Some(value.to_owned()),
            _ => {}
        }
        Ok(())
    }
}

/// Text of the file for an error message, shortened.
fn clip(text: &str) -> String {
    text.chars().take(40).collect()
}
