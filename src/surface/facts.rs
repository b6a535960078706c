//! Facts that follow from the heights alone: size, relief, tilt, whether the patch joins itself, periods.

mod outliers;
mod periods;

use serde::Serialize;

use crate::error::Result;
use crate::plan::Level;
use crate::surface::{HeightField, level};

pub use outliers::{Outliers, outliers};
pub use periods::{AxisPeriods, Peak, Periods, periods};

/// Share of the pixels, in percent, that [`Facts::trimmed_peak_to_valley_um`] leaves out at each end.
pub const TRIM_PERCENT: f64 = 0.1;

/// A patch joins itself along an axis if the step over its seam is at most this many times the step between inner neighbours.
const JOINS: f64 = 1.5;

/// Size and relief of a surface; pairs are `[x, y]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Facts {
    /// Columns and rows.
    pub pixels: [usize; 2],
    /// Size of the patch, µm.
    pub size_um: [f64; 2],
    /// Pixel pitch, µm.
    pub pitch_um: [f64; 2],
    /// Shortest wavelength that the pitch allows, nm: four times the larger pitch.
    pub shortest_nm: f64,
    /// Lowest height, µm.
    pub lowest_um: f64,
    /// Highest height, µm.
    pub highest_um: f64,
    /// Highest minus lowest height, µm.
    pub peak_to_valley_um: f64,
    /// Arithmetic mean, µm.
    pub mean_um: f64,
    /// Root mean square about the mean (ISO 25178-2 Sq), µm.
    pub rms_um: f64,
    /// Root mean square about the least-squares plane, µm.
    pub levelled_rms_um: f64,
    /// Highest minus lowest height after the least-squares plane is subtracted, µm.
    pub levelled_peak_to_valley_um: f64,
    /// The same, without the highest and the lowest [`TRIM_PERCENT`] of the pixels, µm.
    pub trimmed_peak_to_valley_um: f64,
    /// The least-squares plane.
    pub tilt: Tilt,
    /// Step over the seam of the tiling, relative to the step between inner neighbours (root mean squares). 0 if
    /// nothing varies.
    pub seam: [f64; 2],
    /// Whether the patch joins itself along each axis.
    pub joins: [bool; 2],
}

/// The slope of the least-squares plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tilt {
    /// Angle of the plane from the horizontal, degrees.
    pub angle_deg: f64,
    /// Direction of the steepest rise in degrees, from `+x` towards `+y`, 0 to below 360.
    pub direction_deg: f64,
    /// Rise over the patch along x and y, µm.
    pub rise_um: [f64; 2],
}

/// Measures a field.
pub fn facts(field: &HeightField, subject: &str) -> Result<Facts> {
    let (lowest_um, highest_um) = field.range_um();
    let plane = level::fit_plane(field);
    let levelled = level::level(field.clone(), Level::Plane, subject)?;
    let extent = |field: &HeightField| {
        let (low, high) = field.range_um();
        high - low
    };
    let levelled_peak_to_valley_um = extent(&levelled);
    let levelled_rms_um = rms(&levelled);
    let (trimmed, _) = level::clip(levelled, TRIM_PERCENT, subject)?;
    let seam = seams(field);
    let [pitch_x, pitch_y] = [field.pitch_x_um(), field.pitch_y_um()];
    let (slope_x, slope_y) = (plane.per_column_um / pitch_x, -plane.per_row_um / pitch_y);
    Ok(Facts {
        pixels: [field.columns(), field.rows()],
        size_um: [field.size_x_um(), field.size_y_um()],
        pitch_um: [pitch_x, pitch_y],
        shortest_nm: 4e3 * pitch_x.max(pitch_y),
        lowest_um,
        highest_um,
        peak_to_valley_um: highest_um - lowest_um,
        mean_um: plane.mean_um,
        rms_um: rms(field),
        levelled_rms_um,
        levelled_peak_to_valley_um,
        trimmed_peak_to_valley_um: extent(&trimmed),
        tilt: Tilt {
            angle_deg: slope_x.hypot(slope_y).atan().to_degrees(),
            direction_deg: slope_y.atan2(slope_x).to_degrees().rem_euclid(360.0),
            rise_um: [slope_x * field.size_x_um(), slope_y * field.size_y_um()],
        },
        seam,
        joins: joins(field),
    })
}

/// Whether the patch joins itself along x and y when it is tiled.
pub(super) fn joins(field: &HeightField) -> [bool; 2] {
    seams(field).map(|ratio| ratio <= JOINS)
}

fn rms(field: &HeightField) -> f64 {
    let count = field.heights_um().len() as f64;
    let mean = field.heights_um().iter().sum::<f64>() / count;
    (field.heights_um().iter().map(|h| (h - mean) * (h - mean)).sum::<f64>() / count).sqrt()
}

/// Ratio of the step over the seam to the step inside the patch, along x and along y.
fn seams(field: &HeightField) -> [f64; 2] {
    let (columns, rows, heights) = (field.columns(), field.rows(), field.heights_um());
    let mean_square = |squares: &mut dyn Iterator<Item = f64>, count: usize| {
        squares.map(|d| d * d).sum::<f64>() / count.max(1) as f64
    };
    let across = |row: usize| heights[row * columns + columns - 1] - heights[row * columns];
    let inner_x =
        heights.chunks_exact(columns).flat_map(|line| line.windows(2).map(|w| w[1] - w[0]));
    let inner_y = (columns..heights.len()).map(|i| heights[i] - heights[i - columns]);
    let down = (0..columns).map(|c| heights[c] - heights[(rows - 1) * columns + c]);
    let ratio = |seam: f64, inner: f64| if seam == 0.0 { 0.0 } else { (seam / inner).sqrt() };
    [
        ratio(
            mean_square(&mut (0..rows).map(across), rows),
            mean_square(&mut { inner_x }, (columns - 1) * rows),
        ),
        ratio(
            mean_square(&mut { down }, columns),
            mean_square(&mut { inner_y }, columns * (rows - 1)),
        ),
    ]
}
