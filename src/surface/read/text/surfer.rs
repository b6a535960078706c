//! Surfer's text grid, `DSAA`: columns and rows, ranges of x, y and z, then rows from the lowest y upwards.
//!
//! Source: Golden Software, "ASCII grid file format". The first and last places of a range are those of the outer nodes.
//! Lengths have no unit; blank nodes are 1.70141e38.

use crate::error::{Error, Result};
use crate::surface::check_pixels;
use crate::surface::raster::{Lateral, Raster, Samples, Stated};

const BLANK: f64 = 1.701_41e38;

/// Reads a text that begins with the format's mark.
pub(super) fn read(text: &str, subject: &str) -> Option<Result<Raster>> {
    text.strip_prefix("DSAA").map(|body| parse(body, subject))
}

fn parse(body: &str, subject: &str) -> Result<Raster> {
    let broken = |cause: String| {
        Error::new(subject, format!("the Surfer grid {cause}"))
            .remedy("it is truncated or damaged; export it again")
    };
    let mut words = body.split_whitespace();
    let mut next = || {
        let word = words.next().ok_or_else(|| broken("ends in its header".to_owned()))?;
        word.parse::<f64>().map_err(|_| {
            let shown: String = word.chars().take(40).collect();
            broken(format!("has `{shown}` in place of a number"))
        })
    };
    let (columns, rows) = (next()?, next()?);
    let is_count = |n: f64| n.fract() == 0.0 && (0.0..1e9).contains(&n);
    if !is_count(columns) || !is_count(rows) {
        return Err(broken(format!("has {columns} × {rows} nodes")));
    }
    let (columns, rows) = check_pixels(subject, columns as u64, rows as u64)?;
    let (x, y) = ([next()?, next()?], [next()?, next()?]);
    let _heights = [next()?, next()?];
    let count = columns * rows;
    let mut values = Vec::new();
    for _ in 0..count {
        let value = next().map_err(|_| broken(format!("has fewer than {count} heights")))?;
        values.push(if (value / BLANK - 1.0).abs() < 1e-5 { f64::NAN } else { value });
    }
    if next().is_ok() {
        return Err(broken(format!("has more than {count} heights")));
    }
    let values = values.chunks_exact(columns).rev().flatten().copied().collect();
    let pitch = |[low, high]: [f64; 2], count: usize| {
        let step = (high - low) / (count.max(2) - 1) as f64;
        Some(step).filter(|step| step.is_finite() && *step > 0.0)
    };
    let stated = Stated {
        pitch: [pitch(x, columns), pitch(y, rows)],
        lateral: Lateral::Unknown,
        pitch_by: "the ranges of the Surfer grid".to_owned(),
        ..Stated::default()
    };
    Ok(Raster { columns, rows, samples: Samples::Float(values), stated, notes: Vec::new() })
}
