//! `full` on a table that contains the coherence window: one interpolated value for each uniform wavelength.

use crate::defines::Defines;
use crate::error::Result;
use crate::plan::{Illuminant, Variant, Wavelengths};
use crate::surface::HeightField;
use crate::tables::{Series, TableSpec};
use crate::variant::cost::spectrum_bytes;
use crate::variant::tolerance::Promise;
use crate::variant::{Coat, Computation, Cost, ErrorBound, Ground};
use crate::variant::{lay, prefilter};

/// Numbers of the form.
#[derive(Clone, Debug, PartialEq)]
pub struct FullPrefiltered {
    /// The terms.
    pub series: Series,
    patch_um: [f64; 2],
    /// What the surface is made of.
    pub coat: Coat,
    illuminant: Illuminant,
    wavelengths: Wavelengths,
    filters: bool,
}

impl FullPrefiltered {
    pub(in crate::variant) fn new(
        variant: &Variant,
        height: &HeightField,
    ) -> Result<FullPrefiltered> {
        let coat = Coat::new(variant)?;
        Ok(FullPrefiltered {
            series: prefilter::series(variant, height, &coat.matter)?,
            coat,
            patch_um: lay::patch_um(height),
            illuminant: variant.optics.illuminant.clone(),
            wavelengths: variant.wavelengths,
            filters: variant.filters(),
        })
    }
}

impl Computation for FullPrefiltered {
    fn define(&self, wavelengths: usize, into: &mut Defines) {
        self.series.define(into);
        super::define_grid(self.series.size_um, into);
        self.coat.define(wavelengths, 2, into);
        into.count("WAVELENGTH_COUNT", wavelengths, super::WAVELENGTH_COUNT);
    }

    fn coat(&self) -> &Coat {
        &self.coat
    }

    fn tables(&self, on: Ground<'_>) -> Vec<TableSpec> {
        let light = (&self.illuminant, self.wavelengths);
        super::uniform_tables(&self.series, self.filters, light, &self.coat, on)
    }

    fn cost(&self) -> Cost {
        let nodes = self.wavelengths.nodes_nm().len() as u64;
        let bytes = spectrum_bytes(nodes, 2);
        Cost::between(&self.series, (nodes as f64, nodes), self.filters, bytes)
    }

    /// Linear interpolation causes errors of about the same size everywhere (95th percentile 0.9 on a scan, 0.5 on its
    /// map). Steps of the wavelength miss the same narrow lobes as with the bins of the patch.
    fn promise(&self) -> Promise {
        let fine = self.wavelengths.step_nm <= 2.5;
        let model =
            if fine { (prefilter::MODEL_P95, Some(prefilter::MODEL_P95)) } else { (8.0, None) };
        let range_nm = [self.wavelengths.min_nm, self.wavelengths.max_nm];
        Promise::of_series(&self.series, self.filters).converged(&self.series, range_nm, model)
    }

    fn error_bound(&self) -> Option<ErrorBound> {
        prefilter::error_bound(&self.series, self.patch_um)
    }

    fn series(&self) -> Option<&Series> {
        Some(&self.series)
    }

    fn filters(&self) -> bool {
        self.filters
    }
}
