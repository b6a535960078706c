//! Two columns: distance and height.

use super::even::Even;
use super::names::{Column, Role};
use super::numbers::Table;
use crate::error::{Error, Result};

/// Two columns of heights with more rows than this would be a strange matrix.
const MOST_ROWS: usize = 16;

/// The heights of a profile and the step between them. Nothing if the table is a matrix of two columns.
pub(super) fn find(
    table: &Table,
    names: Option<&[Column]>,
    subject: &str,
) -> Result<Option<(f64, Vec<f64>)>> {
    if table.width != 2 || table.rows < 3 {
        return Ok(None);
    }
    let column = |at: usize| table.values.iter().skip(at).step_by(2).copied().collect::<Vec<f64>>();
    let distances = column(0);
    let is_named = names.is_some_and(|names| names[0].role() == Role::X);
    if let Some(Even { step, .. }) = Even::of(&distances) {
        let mut heights = column(1);
        if step < 0.0 {
            heights.reverse();
        }
        return Ok(Some((step.abs(), heights)));
    }
    let rises = distances.is_sorted_by(|a, b| a < b) || distances.is_sorted_by(|a, b| a > b);
    if is_named || (rises && table.rows > MOST_ROWS) {
        return Err(Error::new(subject, "the distances of the profile, its first column, are not evenly spaced")
            .remedy("resample it to even distances in the program that wrote it, and save the heights alone or both columns"));
    }
    if table.rows > MOST_ROWS {
        let cause = format!(
            "{} rows of two numbers are neither distance and height, since the first is not evenly spaced, nor likely a matrix",
            table.rows
        );
        return Err(Error::new(subject, cause)
            .remedy("keep the column of heights; save a matrix of two columns as NPY or GSF"));
    }
    Ok(None)
}
