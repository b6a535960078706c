//! `adaptive` on a table that contains the coherence window. The number of wavelengths depends on the direction, and
//! they are closer where there is more light.

use crate::defines::Defines;
use crate::error::Result;
use crate::plan::{Illuminant, Variant};
use crate::surface::HeightField;
use crate::tables::{
    CoefficientsSpec, LevelsSpec, MatterSpec, NODE_LEVELS, Series, SettingsSpec, TableSpec,
    TermsSpec,
};
use crate::variant::cost::{mean_and_worst, spectrum_bytes};
use crate::variant::lay;
use crate::variant::prefilter::{self, NODE_ERROR, node_counts, node_level};
use crate::variant::tolerance::Promise;
use crate::variant::{Coat, Computation, Cost, ErrorBound, Ground};

/// Numbers of the form.
#[derive(Clone, Debug, PartialEq)]
pub struct Warped {
    /// The terms.
    pub series: Series,
    /// Number of wavelength nodes at every level of `|(u, v)|`. For a single wavelength, one level with one node.
    pub node_counts: Vec<u32>,
    patch_um: [f64; 2],
    range_nm: [f64; 2],
    coherence_um: f64,
    /// What the surface is made of.
    pub coat: Coat,
    /// Least number of columns of the spectrum table.
    columns: Option<usize>,
    illuminant: Illuminant,
    filters: bool,
}

impl Warped {
    pub(in crate::variant) fn new(variant: &Variant, height: &HeightField) -> Result<Warped> {
        let coat = Coat::new(variant)?;
        let range = variant.wavelengths.max_nm > variant.wavelengths.min_nm;
        let needs_columns = range && coat.rows.is_some();
        let columns = if needs_columns { Some(coat.columns(variant)?) } else { None };
        Ok(Warped {
            series: prefilter::series(variant, height, &coat.matter)?,
            node_counts: node_counts(variant, height, &coat.matter),
            coat,
            columns,
            patch_um: lay::patch_um(height),
            range_nm: lay::range_nm(variant),
            coherence_um: variant.optics.coherence_um,
            illuminant: variant.optics.illuminant.clone(),
            filters: variant.filters(),
        })
    }

    fn is_monochromatic(&self) -> bool {
        self.range_nm[1] <= self.range_nm[0]
    }
}

impl Computation for Warped {
    fn define(&self, wavelengths: usize, into: &mut Defines) {
        self.series.define(into);
        super::define_grid(self.series.size_um, into);
        self.coat.define(wavelengths, self.node_counts.len() + 1, into);
        into.count(
            "NODE_LEVELS",
            NODE_LEVELS as usize,
            "number of levels of |(u, v)|, from 0 to 2",
        );
        into.count("WAVELENGTH_COUNT", wavelengths, "maximum number of nodes of a level");
        into.flag("MONOCHROMATIC", wavelengths == 1);
    }

    fn coat(&self) -> &Coat {
        &self.coat
    }

    fn tables(&self, on: Ground<'_>) -> Vec<TableSpec> {
        let terms = TermsSpec {
            surface: on.surface.to_owned(),
            series: self.series.clone(),
            filtered: self.filters,
        };
        let levels = LevelsSpec {
            surface: on.surface.to_owned(),
            coherence_um: self.coherence_um,
            illuminant: self.illuminant.clone(),
            range_nm: self.range_nm,
            counts: self.node_counts.clone(),
            columns: self.columns,
            settings: SettingsSpec::new(on.rotate_deg, &terms, self.coat.rows.clone()),
        };
        let coefficients = CoefficientsSpec::new(on.surface, &self.series);
        let tables = [TableSpec::Terms(terms), TableSpec::Levels(levels)];
        tables.into_iter().chain(coefficients.map(TableSpec::Coefficients)).collect()
    }

    fn cost(&self) -> Cost {
        let widest = self.node_counts.iter().copied().max().map_or(1, u64::from);
        let wavelengths = if self.is_monochromatic() {
            (1.0, 1)
        } else {
            let count =
                |uv: [f64; 2]| u64::from(self.node_counts[node_level(uv[0].hypot(uv[1])) as usize]);
            (mean_and_worst(count).0, widest)
        };
        let columns = widest.max(self.columns.unwrap_or(1) as u64);
        let rows = self.coat.rows.as_ref().map_or(0, MatterSpec::rows);
        let bytes = spectrum_bytes(columns, (self.node_counts.len() + 1 + rows) as u64);
        Cost::between(&self.series, wavelengths, self.filters, bytes)
    }

    /// Linear interpolation and the finite number of nodes cause errors of about the same size everywhere (95th
    /// percentile 0.9 on a scan, 0.5 on its map).
    fn promise(&self) -> Promise {
        let model = (prefilter::MODEL_P95, Some(prefilter::MODEL_P95));
        Promise::of_series(&self.series, self.filters).converged(&self.series, self.range_nm, model)
    }

    fn error_bound(&self) -> Option<ErrorBound> {
        let node_alias = (!self.is_monochromatic()).then_some(NODE_ERROR);
        let bound = prefilter::error_bound(&self.series, self.patch_um)?;
        Some(ErrorBound { node_alias, ..bound })
    }

    fn series(&self) -> Option<&Series> {
        Some(&self.series)
    }

    fn filters(&self) -> bool {
        self.filters
    }
}
