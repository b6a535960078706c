//! What every form answers about itself.

use crate::defines::Defines;
use crate::optics;
use crate::plan::{Colour, Optics};
use crate::tables::{Series, TableSpec};

use super::tolerance::Promise;
use super::{Cost, ErrorBound, FUNCTIONS, Function, LobeBounds};

/// What tables of a surface are named by.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// Identity of the heights; empty where tables need no names.
    pub surface: &'a str,
    /// Rotation of the surface about its normal, degrees.
    pub rotate_deg: f64,
}

/// What every form answers about itself.
pub trait Computation {
    /// What its templates are told. `wavelengths`: nodes of the spectrum table, 1 for a single wavelength.
    fn define(&self, wavelengths: usize, into: &mut Defines);

    /// Its tables, in the order of their bindings.
    fn tables(&self, on: Ground<'_>) -> Vec<TableSpec>;

    /// What a lit pixel costs.
    fn cost(&self) -> Cost;

    /// What comparisons may find.
    fn promise(&self) -> Promise;

    /// Functions that its shader offers.
    fn functions(&self) -> &'static [&'static dyn Function] {
        &FUNCTIONS
    }

    /// A-priori bounds of its approximations; `None` where no error is claimed, or where only a comparison shows it.
    fn error_bound(&self) -> Option<ErrorBound> {
        None
    }

    /// What bounds its loops over lobes, where it has such loops.
    fn lobe_bounds(&self) -> Option<LobeBounds> {
        None
    }

    /// Its terms, where it adds up a series.
    fn series(&self) -> Option<&Series> {
        None
    }

    /// Bins to each side of the nearest one, where it has such a number.
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

    /// Number and length, µm, of the replicas along x and y, where a surface is made of a finite number of them.
    fn replicas(&self) -> Option<[(f64, f64); 2]> {
        None
    }

    /// Why it has no response at a single wavelength; `None` where it has one.
    fn no_wavelength_axis(&self) -> Option<&'static str> {
        None
    }

    /// Radiance relative to a white diffuser per unit of its result; `None` where that has no unit.
    fn diffuser_scale(&self, optics: &Optics) -> Option<f64> {
        Some(optics::diffuser_scale(optics))
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
