//! Levelling of a measured surface, and clipping of its outliers.
//!
//! Tilt and specks of dust increase the peak-to-valley height and so the number of terms, without adding colour.

use crate::error::{Error, Result};
use crate::plan::Level;
use crate::surface::HeightField;

/// Applies a levelling. Afterwards the mean height (`plane`) or the median of every row (`rows`) is 0. That does not
/// matter, since colours depend only on differences of heights.
///
/// `plane` subtracts the least-squares plane, `rows` the median of each row, which removes the offsets between scan
/// lines, and with them every structure that is constant along x. `rows` is an error for a single column, because
/// nothing would remain.
pub fn level(field: HeightField, level: Level, subject: &str) -> Result<HeightField> {
    match level {
        Level::None => Ok(field),
        Level::Plane => plane(field),
        Level::Rows if field.columns == 1 => Err(Error::new(
            subject,
            "`level = \"rows\"` would remove all heights of a single column",
        )
        .remedy("use level = \"plane\" or \"none\"")),
        Level::Rows => rows(field),
    }
}

/// Clips the highest and the lowest `percent` of the pixels to the nearest height that remains.
///
/// Returns the field and a note with the number of clipped pixels and the new range. At 0 nothing changes.
pub fn clip(
    mut field: HeightField,
    percent: f64,
    subject: &str,
) -> Result<(HeightField, Option<String>)> {
    check_clip(subject, percent)?;
    let count = field.heights_um.len();
    // below 50 % the two indices cannot cross
    let skip = ((percent / 100.0 * count as f64).floor() as usize).min((count - 1) / 2);
    if skip == 0 {
        return Ok((field, None));
    }
    let mut sorted = field.heights_um.clone();
    let (_, &mut low, _) = sorted.select_nth_unstable_by(skip, f64::total_cmp);
    let (_, &mut high, _) = sorted.select_nth_unstable_by(count - 1 - skip, f64::total_cmp);
    let mut moved = 0;
    for h in &mut field.heights_um {
        let clipped = h.clamp(low, high);
        moved += usize::from(clipped != *h);
        *h = clipped;
    }
    let note = format!(
        "{moved} of {count} pixels clipped to {low:.4} … {high:.4} µm (clip_percent = {percent})"
    );
    Ok((field, Some(note)))
}

/// Checks `clip_percent`: at least 0 and below 50.
pub(super) fn check_clip(subject: &str, percent: f64) -> Result<()> {
    if (0.0..50.0).contains(&percent) {
        return Ok(());
    }
    Err(Error::new(subject, format!("`clip_percent = {percent}` is not from 0 to below 50"))
        .remedy("give the percentage of pixels clipped at each end"))
}

/// The least-squares plane of a field: `mean_um + per_column_um·(col - mid) + per_row_um·(row - mid)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Height at the centre of the pixels, µm.
    pub mean_um: f64,
    /// Rise from one column to the next, µm.
    pub per_column_um: f64,
    /// Rise from one row to the next, downwards, µm.
    pub per_row_um: f64,
}

/// Fits a plane. On a full grid the centred coordinates are orthogonal, so the two slopes separate and no system needs
/// solving.
pub fn fit_plane(field: &HeightField) -> Plane {
    let (columns, rows) = (field.columns, field.rows);
    let (mid_x, mid_y) = ((columns - 1) as f64 / 2.0, (rows - 1) as f64 / 2.0);
    let mean_um = field.heights_um.iter().sum::<f64>() / field.heights_um.len() as f64;
    let (mut moment_x, mut moment_y) = (0.0, 0.0);
    for (row, line) in field.heights_um.chunks_exact(columns).enumerate() {
        for (col, h) in line.iter().enumerate() {
            moment_x += (col as f64 - mid_x) * (h - mean_um);
            moment_y += (row as f64 - mid_y) * (h - mean_um);
        }
    }
    // Σ (i - mid)² over n places is n(n² - 1)/12
    let spread = |n: usize| (n as f64) * ((n * n) as f64 - 1.0) / 12.0;
    let slope = |moment: f64, n: usize, across: usize| {
        if n > 1 { moment / (spread(n) * across as f64) } else { 0.0 }
    };
    Plane {
        mean_um,
        per_column_um: slope(moment_x, columns, rows),
        per_row_um: slope(moment_y, rows, columns),
    }
}

fn plane(mut field: HeightField) -> Result<HeightField> {
    let Plane { mean_um, per_column_um, per_row_um } = fit_plane(&field);
    let (mid_x, mid_y) = ((field.columns - 1) as f64 / 2.0, (field.rows - 1) as f64 / 2.0);
    for (row, line) in field.heights_um.chunks_exact_mut(field.columns).enumerate() {
        for (col, h) in line.iter_mut().enumerate() {
            *h -=
                mean_um + per_column_um * (col as f64 - mid_x) + per_row_um * (row as f64 - mid_y);
        }
    }
    Ok(field)
}

fn rows(mut field: HeightField) -> Result<HeightField> {
    for line in field.heights_um.chunks_exact_mut(field.columns) {
        let mut sorted = line.to_vec();
        sorted.sort_by(f64::total_cmp);
        let half = sorted.len() / 2;
        let median = if sorted.len().is_multiple_of(2) {
            (sorted[half - 1] + sorted[half]) / 2.0
        } else {
            sorted[half]
        };
        for h in line {
            *h -= median;
        }
    }
    Ok(field)
}
