//! Windows of a scan, and statistics over them.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::surface::HeightField;

use super::Measurement;

/// A part of a surface, in pixels from its top left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// First column.
    pub column: usize,
    /// First row.
    pub row: usize,
    /// Number of columns.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
}

impl Crop {
    /// The heights inside, as a patch with its own centre.
    pub fn of(&self, height: &HeightField) -> Result<HeightField> {
        let Crop { column, row, columns, rows } = *self;
        let lines = height.heights_um().chunks_exact(height.columns()).skip(row).take(rows);
        let inside: Vec<f64> =
            lines.flat_map(|line| line.iter().skip(column).take(columns)).copied().collect();
        HeightField::new(columns, rows, height.pitch_x_um(), height.pitch_y_um(), inside)
    }

    /// Column, row, columns and rows.
    pub fn to_array(self) -> [usize; 4] {
        [self.column, self.row, self.columns, self.rows]
    }
}

/// At least `count` square windows with sides of `side_um`, evenly spread over the surface, row by row from the top left. Their
/// grid is as square as the surface allows. They overlap if there is too little room.
pub fn layout(
    height: &HeightField,
    count: usize,
    side_um: f64,
    subject: &str,
) -> Result<Vec<Crop>> {
    let size = [height.size_x_um(), height.size_y_um()];
    let pitch = [height.pitch_x_um(), height.pitch_y_um()];
    let all = [height.columns(), height.rows()];
    let pixels = [0, 1].map(|i| (side_um / pitch[i]).round() as usize);
    if (0..2).any(|i| pixels[i] < 2 || pixels[i] > all[i]) {
        let cause = format!("windows of {side_um} µm do not fit into {} × {} µm", size[0], size[1]);
        return Err(Error::new(subject, cause).remedy("set a smaller side with --window-um"));
    }
    let room = [0, 1].map(|i| all[i] - pixels[i]);
    let columns = match room {
        [0, _] => 1,
        [_, 0] => count,
        [x, y] => ((count as f64 * x as f64 / y as f64).sqrt().ceil() as usize).clamp(1, count),
    };
    let counts = [columns, if room[1] == 0 { 1 } else { count.div_ceil(columns) }];
    let place = |axis: usize, i: usize| match counts[axis] {
        1 => room[axis] / 2,
        n => (i * room[axis] + (n - 1) / 2) / (n - 1),
    };
    let crop = |i: usize| Crop {
        column: place(0, i % columns),
        row: place(1, i / columns),
        columns: pixels[0],
        rows: pixels[1],
    };
    Ok((0..counts[0] * counts[1]).map(crop).collect())
}

/// Statistics over windows, each weighted by its mean response at the peaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Number of windows with a period.
    pub windows: usize,
    /// Weighted mean of the periods, nm.
    pub period_nm: f64,
    /// Weighted standard deviation of the periods between windows, nm.
    pub spread_nm: f64,
    /// Weighted mean of the standard deviations over wavelengths, nm.
    pub sd_nm: f64,
    /// Mean weight.
    pub weight: f64,
}

/// Statistics over windows; `None` if no window has a period.
pub fn spread<'a>(windows: impl IntoIterator<Item = &'a Measurement>) -> Option<Spread> {
    let all: Vec<&Measurement> = windows.into_iter().filter(|m| m.points > 0).collect();
    let total: f64 = all.iter().map(|m| m.weight).sum();
    let mean = |of: &dyn Fn(&Measurement) -> f64| {
        all.iter().map(|m| m.weight * of(m)).sum::<f64>() / total
    };
    let period_nm = mean(&|m| m.period_nm);
    (total > 0.0).then(|| Spread {
        windows: all.len(),
        period_nm,
        spread_nm: mean(&|m| (m.period_nm - period_nm).powi(2)).sqrt(),
        sd_nm: mean(&|m| m.sd_nm),
        weight: total / all.len() as f64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(columns: usize, rows: usize) -> HeightField {
        let heights = (0..columns * rows).map(|i| i as f64).collect();
        HeightField::new(columns, rows, 0.05, 0.1, heights).expect("valid")
    }

    #[test]
    fn windows_reach_every_edge_and_hold_their_own_pixels() {
        let height = ramp(100, 60);
        let windows = layout(&height, 9, 2.0, "ramp").expect("fits");
        assert!(windows.len() >= 9, "{windows:?}");
        for (far, side) in [
            (windows.iter().map(|w| w.column + w.columns).max(), 100),
            (windows.iter().map(|w| w.row + w.rows).max(), 60),
        ] {
            assert_eq!(far, Some(side));
        }
        assert!(windows.iter().any(|w| w.column == 0 && w.row == 0));
        assert!(windows.iter().all(|w| (w.columns, w.rows) == (40, 20)));
        let cut = Crop { column: 3, row: 5, columns: 4, rows: 2 }.of(&height).expect("inside");
        assert_eq!(cut.heights_um(), [503.0, 504.0, 505.0, 506.0, 603.0, 604.0, 605.0, 606.0]);
        assert_eq!(layout(&height, 1, 5.0, "ramp").expect("fits")[0].to_array(), [0, 5, 100, 50]);
        let error = layout(&height, 4, 6.0, "surface ramp").expect_err("too large").to_string();
        assert!(error.contains("surface ramp") && error.contains("--window-um"), "{error}");
    }

    #[test]
    fn dark_windows_count_little() {
        let of = |period_nm, weight, points| Measurement {
            rows: vec![],
            period_nm,
            sd_nm: 1.0,
            points,
            evanescent: 0,
            flat: 0,
            weight,
            evaluations: 0,
        };
        let all = [of(1000.0, 3.0, 5), of(1100.0, 1.0, 5), of(f64::NAN, 0.0, 0)];
        let found = spread(&all).expect("two windows");
        assert_eq!((found.windows, found.period_nm, found.sd_nm), (2, 1025.0, 1.0));
        assert!((found.spread_nm - 43.301_270_189).abs() < 1e-6, "{found:?}");
        assert_eq!(spread(&all[2..]), None);
    }
}
