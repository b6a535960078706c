//! The matter of a variant's surface, with the rows about it in the spectrum table.

use std::sync::Arc;

use crate::defines::Defines;
use crate::error::{Error, Result};
use crate::optics::Matter;
use crate::plan::Variant;
use crate::tables::MatterSpec;

use super::lay;

/// What the surface is made of, as the shader has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coat {
    /// Material, films and cover.
    pub matter: Arc<Matter>,
    /// Rows of the spectrum table. `None` for a dielectric in air with Stam's obliquity.
    pub rows: Option<MatterSpec>,
}

impl Coat {
    /// The matter of a variant. It is an error, with the reason, if it cannot be computed.
    pub(super) fn new(variant: &Variant) -> Result<Coat> {
        let matter = Matter::new(&variant.optics).map_err(|error| named(variant, &error))?;
        let matter = Arc::new(matter);
        let rows = MatterSpec::new(&variant.optics, &matter, lay::range_nm(variant));
        Ok(Coat { matter, rows: rows.map_err(|error| named(variant, &error))? })
    }

    /// Number of columns that the rows need; 1 without rows. It is an error if that is too many.
    pub(super) fn columns(&self, variant: &Variant) -> Result<usize> {
        let columns = self.rows.as_ref().map_or(Ok(1), MatterSpec::columns);
        columns.map_err(|error| named(variant, &error))
    }

    /// Number of panels per 1/µm of wavenumber that the reflectance needs under lights with a size; 0 without rows. It is
    /// an error if that is too many.
    pub(super) fn panel_pace(&self, variant: &Variant) -> Result<f64> {
        let pace = self.rows.as_ref().map_or(Ok(0.0), MatterSpec::panel_pace);
        pace.map_err(|error| named(variant, &error))
    }

    /// Constants of the template `matter`. `wavelengths`: number of columns of the spectrum table; `above`: number of its
    /// rows for more than one wavelength, without those about the matter.
    pub(super) fn define(&self, wavelengths: usize, above: usize, into: &mut Defines) {
        into.flag("SPECTRAL", true);
        if let Some(rows) = &self.rows {
            rows.define(wavelengths, if wavelengths == 1 { 2 } else { above }, into);
        }
    }
}

/// The error with the variant's name.
fn named(variant: &Variant, error: &Error) -> Error {
    let named = Error::new(&variant.name, error.message());
    match error.advice() {
        Some(advice) => named.remedy(advice),
        None => named,
    }
}
