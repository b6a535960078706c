//! The numbers of a variant that are varied, one at a time, to measure how a frame's time grows.

use diffraction_shaders::error::Result;
use diffraction_shaders::plan::{Auto, Mode, Variant, Wavelengths};
use diffraction_shaders::surface::HeightField;

use super::result::disc_pixels;
use super::surface::{higher, middle};

/// A number that is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Swept {
    /// Pixels of the disc.
    Pixels,
    /// Terms of the series.
    Terms,
    /// Bins to each side of the nearest one.
    Radius,
    /// Wavelength samples.
    Wavelengths,
    /// Width of the range of wavelengths, nm, at the same step.
    Range,
    /// Width of the patch, µm. Patches are cut from the middle of the surface.
    Patch,
    /// Peak to valley, nm. The heights are multiplied by a factor.
    Height,
}

/// One value of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The value.
    pub value: f64,
    /// The amount of work, to which time is expected to be proportional: the value, or for `radius` the number of bins
    /// within it, `(2r + 1)²`.
    pub work: f64,
    /// The variant, under its own name.
    pub variant: Variant,
    /// Heights in place of the surface's, if heights are varied.
    pub height: Option<HeightField>,
    /// Pixels of the frame along x and y.
    pub frame: [usize; 2],
}

impl Swept {
    /// All numbers.
    pub const ALL: [Swept; 7] = [
        Swept::Pixels,
        Swept::Terms,
        Swept::Radius,
        Swept::Wavelengths,
        Swept::Range,
        Swept::Patch,
        Swept::Height,
    ];

    /// The name in records.
    pub fn name(self) -> &'static str {
        match self {
            Swept::Pixels => "pixels",
            Swept::Terms => "terms",
            Swept::Radius => "radius",
            Swept::Wavelengths => "wavelengths",
            Swept::Range => "range",
            Swept::Patch => "patch",
            Swept::Height => "height",
        }
    }

    /// Name of what [`Point::work`] counts.
    pub fn work(self) -> &'static str {
        match self {
            Swept::Radius => "bins",
            other => other.name(),
        }
    }

    /// Four points. Everything else stays as configured. Empty if the mode does not read this number.
    pub fn points(
        self,
        variant: &Variant,
        frame: [usize; 2],
        height: &HeightField,
    ) -> Result<Vec<Point>> {
        let values: [u32; 4] = match self {
            Swept::Pixels | Swept::Patch => [1, 2, 3, 4],
            Swept::Terms => [4, 8, 16, 32],
            // the kernel of `pq` needs a neighbour
            Swept::Radius if variant.mode == Mode::Pq => [1, 2, 3, 4],
            Swept::Radius => [0, 1, 2, 3],
            Swept::Wavelengths => [11, 21, 41, 81],
            Swept::Range => [100, 200, 300, 400],
            Swept::Height => [1, 2, 4, 8],
        };
        let read = |value: u32| self.varied(variant, value).canonical();
        let of_variant = !matches!(self, Swept::Pixels | Swept::Patch | Swept::Height);
        if of_variant && read(values[0]) == read(values[1]) {
            return Ok(Vec::new());
        }
        values.into_iter().map(|number| self.point(number, variant, frame, height)).collect()
    }

    fn varied(self, variant: &Variant, value: u32) -> Variant {
        let mut variant = variant.clone();
        match self {
            Swept::Pixels | Swept::Patch | Swept::Height => {}
            Swept::Terms => variant.terms = Auto::Value(value),
            Swept::Radius => variant.window_radius = Auto::Value(value),
            Swept::Wavelengths => variant.wavelengths = samples(&variant.wavelengths, value),
            Swept::Range => {
                variant.wavelengths.min_nm = MIDDLE_NM - 0.5 * f64::from(value);
                variant.wavelengths.max_nm = MIDDLE_NM + 0.5 * f64::from(value);
            }
        }
        variant
    }

    fn point(
        self,
        number: u32,
        variant: &Variant,
        frame: [usize; 2],
        height: &HeightField,
    ) -> Result<Point> {
        let quarter = |side: usize| (number as usize * side / 4).max(1);
        let frame = if self == Swept::Pixels { frame.map(quarter) } else { frame };
        let field = match self {
            Swept::Patch => Some(middle(height, number)?),
            Swept::Height => Some(higher(height, f64::from(number) / 4.0)?),
            _ => None,
        };
        let shown = field.as_ref().unwrap_or(height);
        let value = match self {
            Swept::Pixels => disc_pixels(frame) as f64,
            Swept::Patch => shown.size_x_um(),
            Swept::Height => {
                let (low_um, high_um) = shown.range_um();
                1e3 * (high_um - low_um)
            }
            _ => f64::from(number),
        };
        let work = match self {
            Swept::Radius => (2.0 * value + 1.0).powi(2),
            _ => value,
        };
        Ok(Point { value, work, variant: self.varied(variant, number), height: field, frame })
    }
}

/// Middle of the varied ranges of wavelengths, as of 380 to 780 nm.
const MIDDLE_NM: f64 = 580.0;

/// `count` samples over the same range.
fn samples(range: &Wavelengths, count: u32) -> Wavelengths {
    Wavelengths { step_nm: (range.max_nm - range.min_nm) / f64::from(count - 1), ..*range }
}

#[cfg(test)]
mod tests {
    use super::*;
    use diffraction_shaders::plan::Optics;

    #[test]
    fn axes_vary_one_number_and_skip_those_that_are_not_read() {
        let heights = (0..64).map(|i| f64::from(i % 7) * 0.05).collect();
        let height = HeightField::new(8, 8, 0.05, 0.05, heights).expect("valid");
        let points =
            |axis: Swept, variant: &Variant| axis.points(variant, [64; 2], &height).expect("valid");
        let texts = Variant::texts(&Optics::standard());
        let values = |axis: Swept, variant: &Variant| -> Vec<f64> {
            points(axis, variant).iter().map(|p| p.value).collect()
        };
        assert_eq!(values(Swept::Terms, &texts), [4.0, 8.0, 16.0, 32.0]);
        let waves = points(Swept::Wavelengths, &texts);
        let counts: Vec<usize> =
            waves.iter().map(|p| p.variant.wavelengths.nodes_nm().len()).collect();
        assert_eq!(counts, [11, 21, 41, 81]);
        let pixels = points(Swept::Pixels, &texts);
        assert!(pixels.iter().all(|p| p.variant == texts), "only the size differs");
        assert_eq!(pixels[3].value, disc_pixels([64; 2]) as f64);
        let radius = points(Swept::Radius, &texts);
        assert_eq!(radius.iter().map(|p| p.work).collect::<Vec<_>>(), [1.0, 9.0, 25.0, 49.0]);
        let range = points(Swept::Range, &texts).remove(0).variant.wavelengths;
        assert_eq!([range.min_nm, range.max_nm], [530.0, 630.0]);
        let close = |axis: Swept, want: [f64; 4]| {
            let got = values(axis, &texts);
            assert!(got.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-9), "{got:?}");
        };
        close(Swept::Patch, [0.1, 0.2, 0.3, 0.4]);
        close(Swept::Height, [75.0, 150.0, 300.0, 600.0]);
        let adaptive = Variant { mode: Mode::Adaptive, ..texts.clone() };
        assert!(values(Swept::Wavelengths, &adaptive).is_empty());
        assert_eq!(values(Swept::Range, &adaptive).len(), 4);
        let gems = Variant { mode: Mode::Gems, ..texts };
        assert!(Swept::ALL[1..5].iter().all(|axis| values(*axis, &gems).is_empty()));
        assert_eq!(values(Swept::Pixels, &gems).len(), 4);
    }
}
