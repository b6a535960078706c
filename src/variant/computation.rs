//! The interface of all forms.

use crate::defines::Defines;
use crate::optics::{Matter, REFERENCE_NM, window_sigma_um};
use crate::plan::{Colour, Optics};
use crate::tables::{Series, TableSpec};

use super::tolerance::Promise;
use super::{Coat, Cost, DIRECTIONAL, ErrorBound, Function, LobeBounds};

/// The facts about a surface that the names of its tables depend on.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// Identity of the heights. Empty if the tables need no names.
    pub surface: &'a str,
    /// Rotation of the surface about its normal, degrees.
    pub rotate_deg: f64,
}

/// The interface of all forms: what text, manifest, comparisons and probes need to know about a form.
pub trait Computation {
    /// Sets the flags and constants of its templates. `wavelengths`: number of nodes of the spectrum table, 1 for a
    /// single wavelength.
    fn define(&self, wavelengths: usize, into: &mut Defines);

    /// What the surface is made of, as the shader has it.
    fn coat(&self) -> &Coat;

    /// What the surface is made of.
    fn matter(&self) -> &Matter {
        &self.coat().matter
    }

    /// Its tables, in the order of their bindings.
    fn tables(&self, on: Ground<'_>) -> Vec<TableSpec>;

    /// Cost of a lit pixel.
    fn cost(&self) -> Cost;

    /// Errors that comparisons may find.
    fn promise(&self) -> Promise;

    /// Functions that its shader offers.
    fn functions(&self) -> Vec<&'static dyn Function> {
        vec![&DIRECTIONAL]
    }

    /// A-priori bounds of its approximations. `None` if no error is claimed, or if only a comparison shows the error.
    fn error_bound(&self) -> Option<ErrorBound> {
        None
    }

    /// Bounds of its loops over lobes, if it has such loops.
    fn lobe_bounds(&self) -> Option<LobeBounds> {
        None
    }

    /// Its terms, if it sums a series.
    fn series(&self) -> Option<&Series> {
        None
    }

    /// Number of bins to each side of the nearest one, if the form has such a number.
    fn window_radius(&self) -> Option<u32> {
        None
    }

    /// Share of a lobe's light in bins that are not read.
    fn missed(&self) -> f64 {
        0.0
    }

    /// Whether it reads a table through the linear filter.
    fn filters(&self) -> bool {
        false
    }

    /// Number of replicas and their length in µm, along x and y, if the surface is a finite number of replicas.
    fn replicas(&self) -> Option<[(f64, f64); 2]> {
        None
    }

    /// The reason why it cannot compute a response at a single wavelength. `None` if it can.
    fn no_wavelength_axis(&self) -> Option<&'static str> {
        None
    }

    /// Whether the unit of its result is arbitrary, so that it cannot be compared with exact colours.
    fn has_arbitrary_unit(&self) -> bool {
        false
    }

    /// Whether its result is meant to be the exact colour, within its error bounds.
    fn claims_truth(&self) -> bool {
        !self.has_arbitrary_unit() && !self.series().is_some_and(Series::is_accepted)
    }

    /// Radiance relative to a white diffuser, per unit of its result. `None` if the unit is arbitrary.
    fn diffuser_scale(&self, optics: &Optics) -> Option<f64> {
        let sigma_um = window_sigma_um(optics, REFERENCE_NM);
        (!self.has_arbitrary_unit()).then(|| self.matter().diffuser_scale(sigma_um))
    }

    /// Unit of its result, in words.
    fn unit(&self) -> &'static str {
        "radiance of a unit directional source, relative to the peak of a mirror at normal incidence"
    }

    /// Colour space of its result, in words.
    fn colour_space(&self, colour: Colour) -> &'static str {
        match colour {
            Colour::Srgb => "scene-linear, sRGB primaries (IEC 61966-2-1), D65",
            Colour::Thesis => "CIE RGB with D65 applied twice; for comparison with the texts only",
        }
    }
}
