//! Coordinates in the first row and the first column of a matrix.

use super::even::Even;
use super::numbers::Table;
use crate::error::{Error, Result};

/// How evenly coordinates have to lie where only that tells them from heights.
const EXACT: f64 = 1e-3;

/// The spacing of the coordinates along x and y that a matrix has.
pub(super) struct Coordinates {
    pub x: Even,
    pub y: Even,
}

/// The coordinates of a matrix with a corner that is empty, NaN or a word. A matrix without that corner whose first row
/// or column looks like coordinates, and whose other rows or columns do not, may be read in two ways: an error.
pub(super) fn find(table: &Table, subject: &str) -> Result<Option<Coordinates>> {
    let Table { values, width, rows, has_corner, .. } = table;
    let (width, rows) = (*width, *rows);
    if width < 3 || rows < 3 {
        return Ok(None);
    }
    let row = |at: usize| &values[at * width + 1..(at + 1) * width];
    let column = |at: usize| (1..rows).map(|r| values[r * width + at]).collect::<Vec<f64>>();
    if *has_corner {
        let found = Even::of(row(0)).zip(Even::of(&column(0)));
        return Ok(found.map(|(x, y)| Coordinates { x, y }));
    }
    // with its corner, so at least four numbers
    let whole_row = |at: usize| Even::within(&values[at * width..(at + 1) * width], EXACT);
    let whole_column = |at: usize| {
        let all: Vec<f64> = (0..rows).map(|r| values[r * width + at]).collect();
        Even::within(&all, EXACT)
    };
    let is_row =
        width > 3 && whole_row(0).is_some() && whole_row(1).is_none() && whole_row(2).is_none();
    let is_column = rows > 3
        && whole_column(0).is_some()
        && whole_column(1).is_none()
        && whole_column(2).is_none();
    // both without their common corner, which may hold any number
    let is_both = Even::within(row(0), EXACT).is_some()
        && Even::within(&column(0), EXACT).is_some()
        && Even::within(row(1), EXACT).is_none()
        && Even::within(&column(1), EXACT).is_none()
        && width > 4
        && rows > 4;
    let what = match (is_row, is_column, is_both) {
        (_, _, true) => "the first row and the first column are",
        (true, ..) => "the first row is",
        (_, true, _) => "the first column is",
        _ => return Ok(None),
    };
    let cause = format!(
        "{what} evenly spaced and the others are not: these numbers may be coordinates or heights"
    );
    Err(Error::new(subject, cause).remedy(
        "remove them if they are coordinates, or write `nan` into their common corner; save heights as NPY or GSF",
    ))
}

/// The matrix inside its coordinates, x to the right and y upwards.
pub(super) fn inside(table: Table, found: &Coordinates) -> (usize, usize, Vec<f64>) {
    let Table { values, width, rows, .. } = table;
    let mut lines: Vec<Vec<f64>> = (1..rows)
        .map(|r| {
            let mut line = values[r * width + 1..(r + 1) * width].to_vec();
            if found.x.step < 0.0 {
                line.reverse();
            }
            line
        })
        .collect();
    // the row of the largest y is the top one
    if found.y.step > 0.0 {
        lines.reverse();
    }
    (width - 1, rows - 1, lines.concat())
}
