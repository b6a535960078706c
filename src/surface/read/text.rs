//! Text matrices: one row of heights per line, top row first; `#` starts a comment.

use super::check_pixels;
use crate::error::{Error, Result};
use crate::surface::raster::{Raster, Samples};

/// Reads numbers separated by white space, commas or semicolons, one kind per file.
///
/// The separator is the semicolon if the file has one, otherwise white space if it has a tab, otherwise the comma if it
/// has one, otherwise white space. So a decimal comma in a file with semicolons or tabs is an error, not a separator.
/// `nan` marks a void pixel.
pub(super) fn read(bytes: &[u8], subject: &str) -> Result<Raster> {
    let error = |cause: String| Error::new(subject, cause);
    let text = std::str::from_utf8(bytes).map_err(|e| {
        error("the text is not UTF-8".into()).source(e).remedy("save it as UTF-8 or ASCII")
    })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = || {
        text.lines().enumerate().filter_map(|(i, line)| {
            let data = line.split('#').next().unwrap_or_default().trim();
            (!data.is_empty()).then_some((i + 1, data))
        })
    };
    let has = |c: char| lines().any(|(_, line)| line.contains(c));
    let separator = [';', '\t', ','].into_iter().find(|&c| has(c));
    let mut values = Vec::new();
    let (mut columns, mut rows, mut first) = (0, 0u64, 0);
    for (number, line) in lines() {
        let before = values.len();
        let mut push = |field: &str| -> Result<()> {
            let column = values.len() - before + 1;
            let value =
                field.parse::<f64>().map_err(|_| not_a_number(subject, number, column, field))?;
            values.push(value);
            Ok(())
        };
        match separator {
            Some(separator @ (';' | ',')) => {
                line.split(separator).map(str::trim).try_for_each(&mut push)?
            }
            _ => line.split_whitespace().try_for_each(&mut push)?,
        }
        let width = values.len() - before;
        if rows == 0 {
            (columns, first) = (width, number);
        } else if width != columns {
            return Err(error(format!(
                "line {number} has {width} numbers, but line {first} has {columns}"
            ))
            .remedy("write the same number of heights in every row"));
        }
        rows += 1;
        check_pixels(subject, columns as u64, rows)?;
    }
    if rows == 0 {
        return Err(
            error("the file has no numbers".into()).remedy("write one row of heights per line")
        );
    }
    let (columns, rows) = check_pixels(subject, columns as u64, rows)?;
    Ok(Raster { columns, rows, samples: Samples::float(values), scale: None, notes: Vec::new() })
}

fn not_a_number(subject: &str, line: usize, column: usize, field: &str) -> Error {
    let shown: String = field.chars().take(40).collect();
    let cause = match shown.as_str() {
        "" => format!("line {line}: field {column} is empty"),
        _ => format!("line {line}: field {column}, `{shown}`, is not a number"),
    };
    let remedy = match field {
        "" => "write `nan` for a void pixel, and no separator at the end of a line",
        _ if field.contains(',') => "write numbers with a decimal point, not a comma",
        _ => "write numbers only; start headings and comments with `#`",
    };
    Error::new(subject, cause).remedy(remedy)
}
