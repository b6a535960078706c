//! Surfaces of other sizes and heights, to measure how a frame's time grows.

use diffraction_shaders::error::Result;
use diffraction_shaders::surface::HeightField;

/// The middle of a surface: `quarters`/4 of its columns and rows, at least two pixels each way.
pub fn middle(height: &HeightField, quarters: u32) -> Result<HeightField> {
    let part = |count: usize| (count * quarters as usize / 4).clamp(count.min(2), count);
    let (columns, rows) = (part(height.columns()), part(height.rows()));
    let (left, top) = ((height.columns() - columns) / 2, (height.rows() - rows) / 2);
    let row = |row: usize| {
        let start = (top + row) * height.columns() + left;
        height.heights_um()[start..start + columns].iter().copied()
    };
    HeightField::new(
        columns,
        rows,
        height.pitch_x_um(),
        height.pitch_y_um(),
        (0..rows).flat_map(row).collect(),
    )
}

/// The surface with all heights multiplied by a factor.
pub fn higher(height: &HeightField, factor: f64) -> Result<HeightField> {
    HeightField::new(
        height.columns(),
        height.rows(),
        height.pitch_x_um(),
        height.pitch_y_um(),
        height.heights_um().iter().map(|h| h * factor).collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_keeps_pitch_and_place_and_factors_scale_the_range() {
        let heights: Vec<f64> = (0..48).map(f64::from).map(|h| h * 0.01).collect();
        let field = HeightField::new(8, 6, 0.05, 0.06, heights).expect("valid");
        let half = middle(&field, 2).expect("valid");
        assert_eq!((half.columns(), half.rows(), half.pitch_y_um()), (4, 3, 0.06));
        assert_eq!(half.heights_um()[0], field.heights_um()[8 + 2]);
        assert_eq!(middle(&field, 4).expect("valid"), field);
        let (low, high) = higher(&field, 2.0).expect("valid").range_um();
        assert!(low == 0.0 && (high - 0.94).abs() < 1e-12, "{high}");
    }
}
