//! The table that the numbers of a block form.

use super::decode::VOIDS;
use super::layout::{Layout, data};
use crate::error::{Error, Result};
use crate::surface::MAX_PIXELS;

/// The numbers of a block, row by row.
#[derive(Debug)]
pub(super) struct Table {
    /// NaN where a cell says that there is no height.
    pub values: Vec<f64>,
    pub width: usize,
    pub rows: usize,
    /// The first line whose width differs: its number, its width, the first line's number.
    pub ragged: Option<(usize, usize, usize)>,
    /// Whether the first cell of the first line is empty, missing, NaN or a word.
    pub has_corner: bool,
    /// What is wrong with an empty or missing corner, unless the table has coordinates.
    pub corner_fault: Option<Error>,
    /// Cells with words for void.
    pub words: usize,
}

/// Reads all numbers.
pub(super) fn table(text: &str, first_line: usize, layout: Layout, subject: &str) -> Result<Table> {
    let mut table = Table {
        values: Vec::new(),
        width: 0,
        rows: 0,
        ragged: None,
        has_corner: false,
        corner_fault: None,
        words: 0,
    };
    let mut first = first_line;
    // some programs end every line with a separator
    let ends = |line: &str| layout.separator.is_some_and(|s| line.ends_with(s));
    let all_end = layout.separator.is_some() && data(text, first_line).all(|(_, line)| ends(line));
    for (number, line) in data(text, first_line) {
        let before = table.values.len();
        let line = if all_end { &line[..line.len() - 1] } else { line };
        match layout.separator {
            Some(separator) => {
                let fields = line.split(separator).map(str::trim);
                fields
                    .enumerate()
                    .try_for_each(|(i, f)| field(&mut table, f, (number, i), layout, subject))?;
            }
            None => {
                let fields = line.split_whitespace();
                fields
                    .enumerate()
                    .try_for_each(|(i, f)| field(&mut table, f, (number, i), layout, subject))?;
            }
        }
        let width = table.values.len() - before;
        match table.rows {
            0 => (table.width, first) = (width, number),
            // a corner of blanks disappears between blanks
            1 if width == table.width + 1 && width > 2 && !table.has_corner => {
                table.values.insert(0, f64::NAN);
                table.corner_fault = Some(ragged(subject, (number, width), (first, width - 1)));
                (table.width, table.has_corner) = (width, true);
            }
            _ if width != table.width && table.ragged.is_none() => {
                table.ragged = Some((number, width, first));
            }
            _ => {}
        }
        table.rows += 1;
        // points need three numbers for each pixel
        if table.values.len() > 4 * MAX_PIXELS {
            return Err(Error::new(
                subject,
                format!("the file has more than {} numbers", 4 * MAX_PIXELS),
            )
            .remedy("crop the surface, or scale it down to a pitch of about 95 nm"));
        }
    }
    table.has_corner |= table.values.first().is_some_and(|v| v.is_nan());
    Ok(table)
}

fn field(
    table: &mut Table,
    field: &str,
    (line, at): (usize, usize),
    layout: Layout,
    subject: &str,
) -> Result<()> {
    let value = match layout.has_decimal_comma {
        true => field.replacen(',', ".", 1).parse::<f64>(),
        false => field.parse::<f64>(),
    };
    let value = match value {
        Ok(value) => value,
        Err(_) => match slow(field, layout) {
            Some(value) => value,
            None if table.values.is_empty() => {
                table.corner_fault = Some(not_a_number(subject, line, at + 1, field));
                f64::NAN
            }
            None => return Err(not_a_number(subject, line, at + 1, field)),
        },
    };
    let is_word = value.is_nan() && !field.eq_ignore_ascii_case("nan");
    table.words += usize::from(is_word && table.corner_fault.is_none());
    table.values.push(value);
    Ok(())
}

/// Numbers in quotes, with a Fortran exponent or a true minus sign, and words for void.
fn slow(field: &str, layout: Layout) -> Option<f64> {
    let bare = field.trim_matches(['"', '\'', ' ']);
    if VOIDS.contains(&bare.to_ascii_lowercase().as_str()) {
        return Some(f64::NAN);
    }
    let plain = bare.replace('−', "-").replace(['D', 'd'], "e");
    let plain = if layout.has_decimal_comma { plain.replacen(',', ".", 1) } else { plain };
    plain.parse().ok()
}

/// The error of a line with another number of fields than the first.
pub(super) fn ragged(
    subject: &str,
    (line, width): (usize, usize),
    (first, first_width): (usize, usize),
) -> Error {
    let cause = format!("line {line} has {width} numbers, but line {first} has {first_width}");
    Error::new(subject, cause).remedy("write the same number of heights in every row")
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
