//! NPY: arrays of floats or of 8-bit or 16-bit unsigned integers, two-dimensional, or one-dimensional for a profile.

use npyz::{DType, Deserialize, NpyFile, Order, TypeChar};

use super::{check_length, check_pixels, grey};
use crate::error::{Error, Result};
use crate::surface::raster::{Raster, Samples, Stated};

/// Maximum length of a header, in bytes. The header of a plain array has 128 bytes.
const MAX_HEADER: usize = 1 << 16;

/// Maximum nesting of brackets in a header. Headers of arrays, even of structured ones, stay within it. Each further
/// level multiplies the time of the crate's parser.
const MAX_NESTING: usize = 4;

/// Reads a file whose magic string has been seen. Arrays are `[row][column]`, in either memory order and byte order.
pub(super) fn read(bytes: &[u8], subject: &str) -> Result<Raster> {
    let error = |cause: String| Error::new(subject, cause);
    let broken = |e: std::io::Error| {
        error("the NPY file cannot be decoded".into())
            .source(e)
            .remedy("the file is truncated or damaged")
    };
    // the crate multiplies the extents unchecked, so they are checked first
    let (start, shape) = declared(bytes).map_err(|cause| {
        error(cause).remedy("the file is damaged or of a rare kind; save it with numpy.save")
    })?;
    let (rows, columns) = match shape[..] {
        [columns] => (1, columns),
        [rows, columns] => (rows, columns),
        _ => {
            return Err(error(format!(
                "the array has {} dimensions, but a height field has two",
                shape.len()
            ))
            .remedy("save a two-dimensional array [row][column]"));
        }
    };
    let (columns, rows) = check_pixels(subject, columns, rows)?;
    let file = NpyFile::new(bytes).map_err(broken)?;
    let unsupported = |dtype: &DType| {
        error(format!("elements of type {} are not supported", dtype.descr()))
            .remedy("save float32 or float64, or uint8 or uint16 with `height_um`")
    };
    let dtype = file.dtype();
    let DType::Plain(kind) = &dtype else { return Err(unsupported(&dtype)) };
    let size = kind.size_field();
    let total = columns as u64 * rows as u64 * size.min(16);
    check_length(subject, bytes.len() - start, total, false)?;
    let order = file.order();
    let samples = match (kind.type_char(), size) {
        (TypeChar::Float, 4) => {
            let values: Vec<f32> = elements(file, order, columns, rows).map_err(broken)?;
            Samples::Float(values.into_iter().map(f64::from).collect())
        }
        (TypeChar::Float, 8) => {
            Samples::Float(elements(file, order, columns, rows).map_err(broken)?)
        }
        (TypeChar::Uint, 1) => grey(
            &elements::<u8>(file, order, columns, rows).map_err(broken)?,
            1,
            false,
            columns,
            8,
            subject,
        )?,
        (TypeChar::Uint, 2) => grey(
            &elements::<u16>(file, order, columns, rows).map_err(broken)?,
            1,
            false,
            columns,
            16,
            subject,
        )?,
        _ => return Err(unsupported(&dtype)),
    };
    Ok(Raster { columns, rows, samples, stated: Stated::default(), notes: Vec::new() })
}

/// All elements row by row, whatever the file's memory order.
fn elements<T: Deserialize + Copy>(
    file: NpyFile<&[u8]>,
    order: Order,
    columns: usize,
    rows: usize,
) -> std::io::Result<Vec<T>> {
    let stored = file.into_vec::<T>()?;
    Ok(match order {
        Order::C => stored,
        Order::Fortran => (0..rows)
            .flat_map(|r| (0..columns).map(move |c| c * rows + r))
            .map(|i| stored[i])
            .collect(),
    })
}

/// Position of the data, and the extents in the header's `shape`.
fn declared(bytes: &[u8]) -> Result<(usize, Vec<u64>), String> {
    let number = |range: std::ops::Range<usize>| {
        let field = bytes.get(range).ok_or("the NPY header is truncated")?;
        Ok::<usize, String>(field.iter().rev().fold(0, |n, &b| n << 8 | usize::from(b)))
    };
    let (text_at, length) = match number(6..7)? {
        1 => (10, number(8..10)?),
        2 | 3 => (12, number(8..12)?),
        version => return Err(format!("NPY version {version} is not supported")),
    };
    if length > MAX_HEADER {
        return Err(format!("the NPY header has {length} bytes, above the limit of {MAX_HEADER}"));
    }
    let header = bytes.get(text_at..text_at + length).ok_or("the NPY header is truncated")?;
    let text = String::from_utf8_lossy(header);
    if nesting(&text) > MAX_NESTING {
        return Err(format!("the NPY header has brackets nested deeper than {MAX_NESTING} levels"));
    }
    // otherwise the crate and this function might read different shapes
    if text.contains('\\') || text.matches("shape").count() > 1 {
        return Err("the NPY header has a backslash, or more than one `shape`".into());
    }
    let shape = text
        .split_once("'shape'")
        .or_else(|| text.split_once("\"shape\""))
        .and_then(|(_, rest)| rest.split_once('('))
        .and_then(|(_, rest)| rest.split_once(')'))
        .map(|(inside, _)| inside)
        .ok_or("the NPY header has no `shape`")?;
    let extents: Result<Vec<u64>, _> = shape
        .split(',')
        .map(str::trim)
        .filter(|s| !s.is_empty())
        .map(|s| {
            s.trim_end_matches('L')
                .parse::<u64>()
                .map_err(|_| format!("the NPY shape ({shape}) is not a list of whole numbers"))
        })
        .collect();
    Ok((text_at + length, extents?))
}

/// Maximum number of brackets that are open at the same time.
fn nesting(text: &str) -> usize {
    let (mut open, mut max) = (0usize, 0);
    for c in text.chars() {
        match c {
            '(' | '[' | '{' => open += 1,
            ')' | ']' | '}' => open = open.saturating_sub(1),
            _ => {}
        }
        max = max.max(open);
    }
    max
}
