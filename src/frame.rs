//! BRDF maps: the square picture of all viewing directions under one light.
//!
//! Pixel centres are `(x, y) ∈ [-1, 1]²`, `+y` up; `sin θr = |(x, y)|`, `φr = atan2(y, x)`; nothing outside the unit disc.

use glam::DVec3;

/// A picture of `size × size` pixels, rows from the top; `None` outside the disc.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Pixels along a side.
    pub size: usize,
    /// Tristimulus values, `[row][column]`.
    pub xyz: Vec<Option<[f64; 3]>>,
}

/// Direction to the viewer of a pixel of a BRDF map, column from the left and row from the top; `None` outside the disc.
pub fn view_direction(column: usize, row: usize, size: usize) -> Option<DVec3> {
    let place = |index: usize| (2 * index + 1) as f64 / size as f64 - 1.0;
    let (x, y) = (place(column), -place(row));
    let squared = x * x + y * y;
    (squared < 1.0).then(|| DVec3::new(x, y, (1.0 - squared).sqrt()))
}

/// The directions of all pixels inside the disc, row by row.
pub fn view_directions(size: usize) -> Vec<DVec3> {
    (0..size * size).filter_map(|i| view_direction(i % size, i / size, size)).collect()
}

impl Frame {
    /// Lays the colours of [`view_directions`] out on the square.
    pub fn from_disc(size: usize, colours: &[[f64; 3]]) -> Frame {
        let mut colours = colours.iter();
        let pixel =
            |i| view_direction(i % size, i / size, size).and_then(|_| colours.next().copied());
        Frame { size, xyz: (0..size * size).map(pixel).collect() }
    }

    /// The colours inside the disc, row by row.
    pub fn disc(&self) -> Vec<[f64; 3]> {
        self.xyz.iter().flatten().copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_is_plus_y_and_the_corners_are_outside() {
        let d = view_direction(4, 0, 8).expect("inside");
        assert!(d.y > 0.8 && d.x > 0.0 && (d.length() - 1.0).abs() < 1e-15, "{d}");
        assert_eq!(view_direction(0, 0, 8), None);
        let disc = view_directions(8);
        let colours: Vec<[f64; 3]> = disc.iter().map(|d| d.to_array()).collect();
        assert_eq!(Frame::from_disc(8, &colours).disc(), colours);
    }
}
