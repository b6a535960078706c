//! How a variant computes on a surface, decided once.

use std::ops::Deref;

use crate::defines::Defines;
use crate::error::Result;
use crate::height::HeightField;
use crate::optics;
use crate::plan::{Colour, Mode, Optics, Reconstruction, Variant};
use crate::tables::{Series, TableSpec};

use super::forms::{Baked, FullPrefiltered, FullWindow, Gems, Lobes, Pq, Warped};
use super::tolerance::Promise;
use super::{Cost, ErrorBound, FUNCTIONS, Function, LobeBounds};

/// A variant on a surface, by the way it computes. Every form holds the numbers that it needs, and no others.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// Bins under the coherence window, uniform wavelengths.
    FullWindow(FullWindow),
    /// A table with the window in it, uniform wavelengths.
    FullPrefiltered(FullPrefiltered),
    /// Replicas of the patch, uniform wavelengths.
    Pq(Pq),
    /// Lobes of the bins that the wavelengths of a direction cross.
    Lobes(Lobes),
    /// A table with the window in it, wavelengths where the light is.
    Warped(Warped),
    /// A table of colours over `(u, v, w)`.
    Baked(Baked),
    /// The order sum of GPU Gems (2004), chapter 8.
    Gems(Gems),
}

impl Form {
    /// Chooses what was left to the tool. Time: arithmetic on the surface's size and height range; for the basis `optimal` a
    /// singular value decomposition, for `gems` a transform. An error is a combination that has no meaning on this surface,
    /// with the reason.
    pub fn new(variant: &Variant, height: &HeightField) -> Result<Form> {
        use Reconstruction::{Prefiltered, Window};
        Ok(match (variant.mode, variant.reconstruction) {
            (Mode::Full, Window) => Form::FullWindow(FullWindow::new(variant, height)?),
            (Mode::Full, Prefiltered) => {
                Form::FullPrefiltered(FullPrefiltered::new(variant, height)?)
            }
            (Mode::Pq, _) => Form::Pq(Pq::new(variant, height)?),
            (Mode::Adaptive, Window) => Form::Lobes(Lobes::new(variant, height)?),
            (Mode::Adaptive, Prefiltered) => Form::Warped(Warped::new(variant, height)?),
            (Mode::Baked, _) => Form::Baked(Baked::new(variant, height)),
            (Mode::Gems, _) => Form::Gems(Gems::new(variant, height)?),
        })
    }

    /// What every form answers.
    fn get(&self) -> &(dyn Computation + 'static) {
        match self {
            Form::FullWindow(form) => form,
            Form::FullPrefiltered(form) => form,
            Form::Pq(form) => form,
            Form::Lobes(form) => form,
            Form::Warped(form) => form,
            Form::Baked(form) => form,
            Form::Gems(form) => form,
        }
    }
}

impl Deref for Form {
    type Target = dyn Computation;

    fn deref(&self) -> &(dyn Computation + 'static) {
        self.get()
    }
}

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
