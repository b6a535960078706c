//! `pq`: a finite number of replicas of the patch, without a coherence window.

use crate::defines::Defines;
use crate::error::Result;
use crate::plan::{Auto, Illuminant, Optics, Variant, Wavelengths};
use crate::surface::HeightField;
use crate::tables::{Reach, Series, TableSpec};
use crate::variant::tolerance::Promise;
use crate::variant::{
    AUTO_TAIL_PQ, Coat, Computation, Cost, ErrorBound, Ground, lay, replica_tail,
};

/// Numbers of the form.
#[derive(Clone, Debug, PartialEq)]
pub struct Pq {
    /// The terms.
    pub series: Series,
    /// Bins to each side of the nearest one.
    pub window_radius: u32,
    /// Replicas along x and y.
    pub periods: [u32; 2],
    /// Number of bins along x and y that are interpolated between: `2·radius + 1`, but at most the number of pixels.
    pub taps: [u32; 2],
    /// Pixels along x and y.
    pub pixels: [u32; 2],
    /// What the surface is made of.
    pub coat: Coat,
    illuminant: Illuminant,
    wavelengths: Wavelengths,
}

/// Maximum number of replicas along an axis.
const MAX_PERIODS: f64 = 10000.0;

impl Pq {
    pub(in crate::variant) fn new(variant: &Variant, height: &HeightField) -> Result<Pq> {
        let patch_um = lay::patch_um(height);
        let pixels = [height.columns() as u32, height.rows() as u32];
        let coherence_um = variant.optics.coherence_um;
        let coat = Coat::new(variant)?;
        let expansion = lay::expansion(variant, height, &coat.matter)?;
        let periods = variant.periods.unwrap_or_else(|| {
            patch_um.map(|size_um| (coherence_um / size_um).round().clamp(1.0, MAX_PERIODS) as u32)
        });
        let (window_radius, reach) = match variant.window_radius {
            Auto::Value(radius) => (radius, Reach::Radius(radius)),
            Auto::Auto => {
                let tail = |radius| replica_tail(periods, taps(radius, pixels), pixels);
                let reach = Reach::Replicas { periods: variant.periods, coherence_um };
                // interpolation needs at least one neighbour
                (lay::radius(1, AUTO_TAIL_PQ, tail), reach)
            }
        };
        let margin = [window_radius as usize + 1; 2];
        let bins = lay::bins(patch_um, variant.wavelengths.min_nm, margin);
        let texels = (variant.packing, variant.table);
        Ok(Pq {
            series: Series::new(expansion, reach, bins, None, patch_um, texels),
            window_radius,
            periods,
            taps: taps(window_radius, pixels),
            pixels,
            coat,
            illuminant: variant.optics.illuminant.clone(),
            wavelengths: variant.wavelengths,
        })
    }

    fn tail(&self) -> f64 {
        replica_tail(self.periods, self.taps, self.pixels)
    }
}

fn taps(radius: u32, pixels: [u32; 2]) -> [u32; 2] {
    pixels.map(|count| count.min(2 * radius + 1))
}

impl Computation for Pq {
    fn define(&self, wavelengths: usize, into: &mut Defines) {
        self.series.define(into);
        super::define_patch(self.series.size_um, into);
        self.coat.define(wavelengths, 2, into);
        into.count("WAVELENGTH_COUNT", wavelengths, super::WAVELENGTH_COUNT);
        let [columns, rows] = self.periods.map(f64::from);
        into.number("PERIOD_COLUMNS", columns, "number of replicas of the patch along x");
        into.number("PERIOD_ROWS", rows, "number of replicas of the patch along y");
        let [columns, rows] = self.pixels.map(f64::from);
        into.number("PIXEL_COLUMNS", columns, "number of pixels of the patch along x");
        into.number("PIXEL_ROWS", rows, "number of pixels of the patch along y");
        let [columns, rows] = self.taps.map(|count| count as usize);
        into.count("TAP_COLUMNS", columns, "number of bins along x that are interpolated between");
        into.count("TAP_ROWS", rows, "number of bins along y that are interpolated between");
    }

    fn coat(&self) -> &Coat {
        &self.coat
    }

    fn tables(&self, on: Ground<'_>) -> Vec<TableSpec> {
        let light = (&self.illuminant, self.wavelengths);
        super::uniform_tables(&self.series, false, light, &self.coat, on)
    }

    fn cost(&self) -> Cost {
        let taps = u64::from(self.taps[0]) * u64::from(self.taps[1]);
        Cost::uniform(&self.series, self.wavelengths.nodes_nm().len(), taps)
    }

    /// The lines have another shape than the window's lobes, so colours differ from the reference by an unknown amount.
    fn promise(&self) -> Promise {
        Promise::of_series(&self.series, false)
    }

    fn error_bound(&self) -> Option<ErrorBound> {
        Some(ErrorBound::new(&self.series, Some(self.window_radius), self.tail()))
    }

    fn series(&self) -> Option<&Series> {
        Some(&self.series)
    }

    fn window_radius(&self) -> Option<u32> {
        Some(self.window_radius)
    }

    fn missed(&self) -> f64 {
        self.tail()
    }

    fn replicas(&self) -> Option<[(f64, f64); 2]> {
        Some([0, 1].map(|axis| (f64::from(self.periods[axis]), self.series.size_um[axis])))
    }

    fn diffuser_scale(&self, _: &Optics) -> Option<f64> {
        let sides = [0, 1].map(|i| f64::from(self.periods[i]) * self.series.size_um[i]);
        Some(self.coat.matter.replica_diffuser_scale(sides))
    }
}
