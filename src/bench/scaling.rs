//! Which numbers of a variant are varied, one at a time, to see what a frame's time depends on.

use super::result::disc_pixels;
use crate::plan::{Auto, Mode, Variant, Wavelengths};

/// A number that is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Pixels of the disc.
    Pixels,
    /// Terms of the series.
    Terms,
    /// Bins to each side of the nearest one.
    Radius,
    /// Wavelength samples.
    Wavelengths,
}

/// One value of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The value.
    pub value: f64,
    /// What work is expected to be proportional to: the value, or of `radius` the bins within it, `(2r + 1)²`.
    pub work: f64,
    /// The variant, under its own name.
    pub variant: Variant,
    /// Pixels along a side of the map.
    pub size: usize,
}

impl Axis {
    /// All of them.
    pub const ALL: [Axis; 4] = [Axis::Pixels, Axis::Terms, Axis::Radius, Axis::Wavelengths];

    /// The name in records.
    pub fn name(self) -> &'static str {
        match self {
            Axis::Pixels => "pixels",
            Axis::Terms => "terms",
            Axis::Radius => "radius",
            Axis::Wavelengths => "wavelengths",
        }
    }

    /// What [`Point::work`] counts.
    pub fn work(self) -> &'static str {
        match self {
            Axis::Radius => "bins",
            other => other.name(),
        }
    }

    /// Four points, everything else as configured; empty for a number that the mode does not read.
    pub fn points(self, variant: &Variant, size: usize) -> Vec<Point> {
        let varied = |value: u32| {
            let mut variant = variant.clone();
            match self {
                Axis::Pixels => {}
                Axis::Terms => variant.terms = Auto::Value(value),
                Axis::Radius => variant.window_radius = Auto::Value(value),
                Axis::Wavelengths => variant.wavelengths = samples(&variant.wavelengths, value),
            }
            variant
        };
        let values: [u32; 4] = match self {
            Axis::Pixels => [1, 2, 3, 4].map(|quarters| (quarters * size as u32 / 4).max(1)),
            Axis::Terms => [4, 8, 16, 32],
            // the kernel of `pq` is no kernel without a neighbour
            Axis::Radius if variant.mode == Mode::Pq => [1, 2, 3, 4],
            Axis::Radius => [0, 1, 2, 3],
            Axis::Wavelengths => [11, 21, 41, 81],
        };
        if self != Axis::Pixels && varied(values[0]).canonical() == varied(values[1]).canonical() {
            return Vec::new();
        }
        let point = |number: u32| {
            let size = if self == Axis::Pixels { number as usize } else { size };
            let (value, work) = match self {
                Axis::Pixels => (disc_pixels(size) as f64, disc_pixels(size) as f64),
                Axis::Radius => (f64::from(number), f64::from(2 * number + 1).powi(2)),
                _ => (f64::from(number), f64::from(number)),
            };
            Point { value, work, variant: varied(number), size }
        };
        values.map(point).into()
    }
}

/// So many samples over the same range.
fn samples(range: &Wavelengths, count: u32) -> Wavelengths {
    Wavelengths { step_nm: (range.max_nm - range.min_nm) / f64::from(count - 1), ..*range }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Optics;

    #[test]
    fn axes_vary_one_number_and_skip_those_that_are_not_read() {
        let texts = Variant::texts(&Optics::standard());
        let values = |axis: Axis, variant: &Variant| -> Vec<f64> {
            axis.points(variant, 64).iter().map(|p| p.value).collect()
        };
        assert_eq!(values(Axis::Terms, &texts), [4.0, 8.0, 16.0, 32.0]);
        let waves = Axis::Wavelengths.points(&texts, 64);
        let counts: Vec<usize> =
            waves.iter().map(|p| p.variant.wavelengths.nodes_nm().len()).collect();
        assert_eq!(counts, [11, 21, 41, 81]);
        let pixels = Axis::Pixels.points(&texts, 64);
        assert!(pixels.iter().all(|p| p.variant == texts), "only the size differs");
        assert_eq!(pixels[3].value, disc_pixels(64) as f64);
        let radius = Axis::Radius.points(&texts, 64);
        assert_eq!(radius.iter().map(|p| p.work).collect::<Vec<_>>(), [1.0, 9.0, 25.0, 49.0]);
        let adaptive = Variant { mode: Mode::Adaptive, ..texts.clone() };
        assert!(values(Axis::Wavelengths, &adaptive).is_empty());
        let gems = Variant { mode: Mode::Gems, ..texts };
        assert!(Axis::ALL[1..].iter().all(|axis| values(*axis, &gems).is_empty()));
        assert_eq!(values(Axis::Pixels, &gems).len(), 4);
    }
}
