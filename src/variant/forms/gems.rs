//! `gems`: the order sum of GPU Gems (2004), chapter 8, a comparator without a stated error.

use crate::defines::Defines;
use crate::error::{Error, Result};
use crate::plan::{Colour, Variant};
use crate::surface::HeightField;
use crate::tables::{GratingSpec, TableSpec, strongest_period_um};
use crate::variant::cost::spectrum_bytes;
use crate::variant::tolerance::Promise;
use crate::variant::{Coat, Computation, Cost, Ground};

/// The form has no numbers of its own: the period is in its table. It reads no optics.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gems {
    coat: Coat,
}

impl Gems {
    pub(in crate::variant) fn new(variant: &Variant, height: &HeightField) -> Result<Gems> {
        strongest_period_um(height).map(|_| Gems::default()).ok_or_else(|| {
            Error::new(&variant.name, "a flat surface has no period")
                .remedy("use mode = \"gems\" for gratings only")
        })
    }
}

impl Computation for Gems {
    fn define(&self, _: usize, _: &mut Defines) {}

    fn coat(&self) -> &Coat {
        &self.coat
    }

    fn tables(&self, on: Ground<'_>) -> Vec<TableSpec> {
        let (surface, rotate_deg) = (on.surface.to_owned(), on.rotate_deg);
        vec![TableSpec::Grating(GratingSpec { surface, rotate_deg })]
    }

    fn cost(&self) -> Cost {
        let table_bytes = spectrum_bytes(1, 2);
        Cost { fetches: 1, fetches_mean: 1.0, table_bytes, ..Cost::default() }
    }

    fn promise(&self) -> Promise {
        Promise::comparator()
    }

    fn no_wavelength_axis(&self) -> Option<&'static str> {
        Some("has no wavelength axis: it maps the wavelength of each order to a colour")
    }

    fn has_arbitrary_unit(&self) -> bool {
        true
    }

    fn unit(&self) -> &'static str {
        "arbitrary: a rainbow for every order, no radiance and no error claimed"
    }

    fn colour_space(&self, _: Colour) -> &'static str {
        "the chapter's display colours, taken as scene-linear sRGB"
    }
}
