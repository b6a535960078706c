//! Points `x y z` on a regular grid, in any order.

use super::even::Even;
use crate::error::{Error, Result};
use crate::surface::check_pixels;

/// Heights on the grid that points lie on.
pub(super) struct Grid {
    pub columns: usize,
    pub rows: usize,
    /// Step along x and y, in the unit of the coordinates.
    pub pitch: [f64; 2],
    /// `[row][column]`, the row of the largest y first.
    pub values: Vec<f64>,
}

/// Why points lie on no grid.
pub(super) enum Fault {
    /// They do not look like points: most places differ in both coordinates, or a coordinate never changes.
    NoPoints,
    /// They are points, and this is wrong with them.
    Words(String),
}

/// Puts points on their grid. `point` returns the x, y, z of one of `count` points.
pub(super) fn grid(
    count: usize,
    point: impl Fn(usize) -> [f64; 3],
    subject: &str,
) -> Result<std::result::Result<Grid, Fault>> {
    let places = |axis: usize| {
        let mut all: Vec<f64> = (0..count).map(|i| point(i)[axis]).collect();
        all.sort_unstable_by(f64::total_cmp);
        all.dedup();
        all
    };
    let (xs, ys) = (places(0), places(1));
    let (columns, rows) = (xs.len(), ys.len());
    let finite = |all: &[f64]| all.iter().all(|v| v.is_finite());
    if columns < 2 || rows < 2 || count < 4 || !finite(&xs) || !finite(&ys) {
        return Ok(Err(Fault::NoPoints));
    }
    let cells = columns as u64 * rows as u64;
    let (Some(along_x), Some(along_y)) = (Even::of(&xs), Even::of(&ys)) else {
        // a grid whose steps differ, or a scatter
        let fault = if cells <= 2 * count as u64 {
            Fault::Words(format!(
                "{count} points lie on {columns} × {rows} lines that are not evenly spaced"
            ))
        } else {
            Fault::NoPoints
        };
        return Ok(Err(fault));
    };
    if cells > 4 * count as u64 {
        return Ok(Err(Fault::NoPoints));
    }
    check_pixels(subject, columns as u64, rows as u64)?;
    let mut values = vec![None; columns * rows];
    for i in 0..count {
        let [x, y, z] = point(i);
        let (Some(column), Some(up)) = (along_x.place(x, columns), along_y.place(y, rows)) else {
            return Ok(Err(Fault::NoPoints));
        };
        let cell: &mut Option<f64> = &mut values[(rows - 1 - up) * columns + column];
        if cell.replace(z).is_some() {
            return Ok(Err(Fault::Words(format!("two points lie at x = {x}, y = {y}"))));
        }
    }
    let missing = values.iter().filter(|cell| cell.is_none()).count();
    if missing > 0 {
        return Ok(Err(Fault::Words(format!(
            "{count} points fill only {:.1} % of a grid of {columns} × {rows}; {missing} are missing",
            100.0 * count as f64 / cells as f64
        ))));
    }
    let values = values.into_iter().flatten().collect();
    Ok(Ok(Grid { columns, rows, pitch: [along_x.step, along_y.step], values }))
}

/// The error of points that lie on no grid.
pub(super) fn refuse(words: &str, subject: &str) -> Error {
    Error::new(subject, words).remedy(
        "a surface needs one height at every place of a regular grid: interpolate the points in the program that wrote them, write `nan` as the height of places without one, and save a matrix or a GSF file",
    )
}
