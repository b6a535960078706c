//! The algorithms of the templates in f64, function by function.
//!
//! `twin/x.rs` stands beside `templates/x.wgsl` with the same function names. What every mode shares is not written
//! twice: the f64 form of `gain.wgsl` is [`crate::optics`], that of the map's geometry [`crate::frame`].

mod adaptive;
mod baked;
pub mod full;
mod gems;
pub mod mesh;
mod nodes;
mod pq;
mod prefiltered;
mod series;
mod warped;
mod window;

use glam::DVec3;

use crate::plan::{Mode, Optics, Variant};
use crate::reference::Directions;
use crate::resolve::Resolved;
use crate::spectrum::Sample;
use crate::tables::{TERMS, Table, spectrum_table};

/// Everything that one pixel of a variant reads, and the variant's algorithm on it.
#[derive(Clone, Copy)]
pub struct Twin<'a> {
    /// Counts and sizes.
    pub resolved: &'a Resolved,
    /// Term table, or the table of colours, rounded or not; empty where the mode has none.
    pub terms: &'a Table,
    /// Spectrum table, rounded or not.
    pub spectrum: &'a Table,
    /// Table of coefficients, rounded or not; empty where they are powers.
    pub coefficients: &'a Table,
    /// The variant; only what the template's defines hold is read.
    pub variant: &'a Variant,
    /// Rotation of the surface, degrees.
    pub rotate_deg: f64,
}

impl<'a> Twin<'a> {
    /// Takes the tables by their names.
    pub fn new(
        resolved: &'a Resolved,
        tables: &'a [Table],
        variant: &'a Variant,
        rotate_deg: f64,
    ) -> Twin<'a> {
        let named = |name: &str| tables.iter().find(|t| t.name == name).unwrap_or(&ABSENT);
        Twin {
            resolved,
            terms: tables.iter().find(|t| t.binding == TERMS).unwrap_or(&ABSENT),
            spectrum: named("spectrum"),
            coefficients: named("coefficients"),
            variant,
            rotate_deg,
        }
    }

    /// Relative tristimulus values of `ρ`.
    pub fn tristimulus(&self, directions: Directions) -> [f64; 3] {
        let prefiltered = self.resolved.grid.is_some();
        match self.variant.mode {
            Mode::Adaptive if prefiltered => warped::tristimulus(self, directions),
            Mode::Full | Mode::Pq => nodes::tristimulus(self, directions),
            Mode::Adaptive => adaptive::tristimulus(self, directions),
            Mode::Gems => gems::tristimulus(self, directions),
            Mode::Baked => baked::tristimulus(self, directions),
        }
    }

    /// `|P|²` of this variant at one wavelength, µm, along `path = (u, v, w)`; `None` where it has no wavelengths.
    pub fn response(&self, path: DVec3, lambda_um: f64) -> Option<f64> {
        match self.variant.mode {
            _ if self.resolved.grid.is_some() => Some(prefiltered::response(self, path, lambda_um)),
            Mode::Full => Some(full::response(self, path, lambda_um)),
            Mode::Pq => Some(pq::response(self, path, lambda_um)),
            // the segment shrinks to a point
            Mode::Adaptive => {
                let sample = Sample { lambda_nm: 1e3 * lambda_um, xyz: [1.0; 3] };
                let spectrum = spectrum_table(&[sample], self.rotate_deg, self.resolved.scale);
                Some(adaptive::corridor(&Twin { spectrum: &spectrum, ..*self }, path).x)
            }
            Mode::Gems | Mode::Baked => None,
        }
    }

    /// Whether the spectrum is a single wavelength.
    fn is_monochromatic(&self) -> bool {
        self.spectrum.width == 1
    }

    fn optics(&self) -> &Optics {
        &self.variant.optics
    }
}

impl mesh::OrientationMap {
    /// No angle anywhere: for meshes whose vertices have all angles.
    pub fn none() -> mesh::OrientationMap {
        mesh::OrientationMap { width: 1, height: 1, angles: vec![0.0] }
    }
}

static ABSENT: Table = Table::ABSENT;
