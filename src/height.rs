//! Height fields: heights in µm on a regular grid with a physical pitch.

use crate::error::{Error, Result, Stage};

/// Heights of one patch, which tiles the plane periodically.
///
/// Row-major, **row 0 at the top** (largest y); pixel (col, row) lies at `x = col·pitch_x - Lx/2`,
/// `y = (rows-1-row)·pitch_y - Ly/2`, so `+x` is to the right and `+y` is up the picture. All heights are finite.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    columns: usize,
    rows: usize,
    pitch_x_um: f64,
    pitch_y_um: f64,
    heights_um: Vec<f64>,
}

impl HeightField {
    /// Checks shape, pitch and heights (`heights_um[row][column]`, finite).
    pub fn new(
        columns: usize,
        rows: usize,
        pitch_x_um: f64,
        pitch_y_um: f64,
        heights_um: Vec<f64>,
    ) -> Result<HeightField> {
        let subject = format!("height field of {columns} × {rows} pixels");
        if columns == 0 || rows == 0 || columns.checked_mul(rows) != Some(heights_um.len()) {
            return Err(Error::new(
                Stage::Height,
                subject,
                format!("has {} heights", heights_um.len()),
            ));
        }
        if !(pitch_x_um.is_finite()
            && pitch_x_um > 0.0
            && pitch_y_um.is_finite()
            && pitch_y_um > 0.0)
        {
            let cause =
                format!("pixel pitch {pitch_x_um} × {pitch_y_um} µm is not positive and finite");
            return Err(Error::new(Stage::Height, subject, cause));
        }
        if let Some(at) = heights_um.iter().position(|h| !h.is_finite()) {
            let cause = format!(
                "height {} at column {}, row {}",
                heights_um[at],
                at % columns,
                at / columns
            );
            return Err(Error::new(Stage::Height, subject, cause));
        }
        Ok(HeightField { columns, rows, pitch_x_um, pitch_y_um, heights_um })
    }

    /// Pixels along x.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Pixels along y.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Pixel pitch along x, µm.
    pub fn pitch_x_um(&self) -> f64 {
        self.pitch_x_um
    }

    /// Pixel pitch along y, µm.
    pub fn pitch_y_um(&self) -> f64 {
        self.pitch_y_um
    }

    /// Patch width `Lx`, µm.
    pub fn size_x_um(&self) -> f64 {
        self.columns as f64 * self.pitch_x_um
    }

    /// Patch height `Ly`, µm.
    pub fn size_y_um(&self) -> f64 {
        self.rows as f64 * self.pitch_y_um
    }

    /// Heights, µm, `[row][column]`, row 0 at the top.
    pub fn heights_um(&self) -> &[f64] {
        &self.heights_um
    }

    /// Lowest and highest height, µm.
    pub fn range_um(&self) -> (f64, f64) {
        let fold = |f: fn(f64, f64) -> f64, start| self.heights_um.iter().copied().fold(start, f);
        (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY))
    }
}
