//! Void pixels: pixels without a measured height, NaN in the file.

use crate::error::{Error, Result};
use crate::surface::HeightField;
use crate::surface::read::Reading;

/// Maximum share of void pixels that is filled. With more, invented heights would affect the colours.
pub const MAX_VOID_SHARE: f64 = 0.2;

/// Replaces void pixels (NaN) by a smooth surface through their neighbours, and returns a note with their number.
///
/// The fill grows inwards ring by ring: each pixel becomes the mean of its known neighbours among eight. It then
/// relaxes towards the solution of Laplace's equation, with the known heights as boundary and mirrored edges (the file
/// may not be periodic). It stays within the range of the known heights. It is an error if all pixels are void, or more
/// than [`MAX_VOID_SHARE`].
pub fn fill(reading: Reading, subject: &str) -> Result<(HeightField, Vec<String>)> {
    let Reading { columns, rows, pitch_x_um, pitch_y_um, mut heights_um, mut notes, .. } = reading;
    let void: Vec<usize> = (0..heights_um.len()).filter(|&i| heights_um[i].is_nan()).collect();
    if !void.is_empty() {
        let share = void.len() as f64 / heights_um.len() as f64;
        let remedy = "crop the scan, or fill the void pixels in the program that exported it";
        if void.len() == heights_um.len() {
            return Err(Error::new(subject, "every pixel is void (NaN)").remedy(remedy));
        }
        let counted = format!(
            "{} of {} pixels are void ({:.2} %)",
            void.len(),
            heights_um.len(),
            share * 100.0
        );
        if share > MAX_VOID_SHARE {
            let cause = format!("{counted}, above the limit of {} %", MAX_VOID_SHARE * 100.0);
            return Err(Error::new(subject, cause).remedy(remedy));
        }
        grow(&mut heights_um, columns, rows, &void);
        relax(&mut heights_um, columns, rows, &void);
        notes.push(format!("{counted}; filled from their neighbours"));
    }
    Ok((HeightField::new(columns, rows, pitch_x_um, pitch_y_um, heights_um)?, notes))
}

/// Fills rings of void pixels from known neighbours until all are filled.
fn grow(heights: &mut [f64], columns: usize, rows: usize, void: &[usize]) {
    let mean_of_known = |heights: &[f64], at: usize| {
        let (sum, count) = around(at, columns, rows)
            .map(|i| heights[i])
            .filter(|h| !h.is_nan())
            .fold((0.0, 0), |(sum, count), h| (sum + h, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    };
    let mut ring: Vec<usize> = void.to_vec();
    while !ring.is_empty() {
        // every ring is computed from the state before it, so the order of pixels has no effect
        let values: Vec<(usize, f64)> =
            ring.iter().filter_map(|&at| Some((at, mean_of_known(heights, at)?))).collect();
        for &(at, value) in &values {
            heights[at] = value;
        }
        let mut next: Vec<usize> = values
            .iter()
            .flat_map(|&(at, _)| around(at, columns, rows))
            .filter(|&i| heights[i].is_nan())
            .collect();
        next.sort_unstable();
        next.dedup();
        ring = next;
    }
}

/// Gauss–Seidel sweeps of the five-point Laplace equation over the void pixels, forwards and backwards in turn.
fn relax(heights: &mut [f64], columns: usize, rows: usize, void: &[usize]) {
    // the work is bounded: large holes are smooth after growing, small ones converge
    let sweeps = (400_000_000 / void.len()).clamp(4, 400);
    let (low, high) =
        heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
    let enough = (high - low) * 1e-7;
    let mut step = |at: usize| {
        let (col, row) = (at % columns, at / columns);
        let left = heights[if col > 0 { at - 1 } else { at }];
        let right = heights[if col + 1 < columns { at + 1 } else { at }];
        let above = heights[if row > 0 { at - columns } else { at }];
        let below = heights[if row + 1 < rows { at + columns } else { at }];
        let new = (left + right + above + below) / 4.0;
        let change = (new - heights[at]).abs();
        heights[at] = new;
        change
    };
    for sweep in 0..sweeps {
        let change = if sweep % 2 == 0 {
            void.iter().map(|&at| step(at)).fold(0.0, f64::max)
        } else {
            void.iter().rev().map(|&at| step(at)).fold(0.0, f64::max)
        };
        if change <= enough {
            break;
        }
    }
}

/// The up to eight neighbours of a pixel.
fn around(at: usize, columns: usize, rows: usize) -> impl Iterator<Item = usize> {
    let (col, row) = (at % columns, at / columns);
    let (lines, places) =
        (row.saturating_sub(1)..(row + 2).min(rows), col.saturating_sub(1)..(col + 2).min(columns));
    lines.flat_map(move |r| places.clone().map(move |c| r * columns + c)).filter(move |&i| i != at)
}
