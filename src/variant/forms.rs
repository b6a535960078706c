//! Forms: the ways in which a variant computes on a surface, one file for each, and the choice between them.

mod baked;
mod full_prefiltered;
mod full_window;
mod gems;
mod lobes;
mod orders;
mod pq;
mod warped;

use std::ops::Deref;

use crate::defines::Defines;
use crate::error::Result;
use crate::optics::REFERENCE_NM;
use crate::plan::{
    Coherence, CoherenceScaling, Illuminant, Mode, Reconstruction, Variant, Wavelengths, Window,
};
use crate::surface::HeightField;
use crate::tables::{CoefficientsSpec, NodesSpec, Series, SettingsSpec, TableSpec, TermsSpec};

use super::{Coat, Computation, Ground, Pattern};

pub use baked::{
    Baked, DISC_INNER, DISC_INNER_SHARE, DISC_LOBES, DISC_RING_VARIANCE, DISC_RINGS, DISC_SHARE,
    Wide,
};
pub use full_prefiltered::FullPrefiltered;
pub use full_window::FullWindow;
pub use gems::Gems;
pub use lobes::{LobeSum, Lobes};
pub use orders::Orders;
pub use pq::Pq;
pub use warped::Warped;

/// A variant on a surface, by the way it computes. Every form has only the numbers that it needs.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// Sum over bins under the coherence window, at uniform wavelengths.
    FullWindow(FullWindow),
    /// Interpolation in a table that contains the window, at uniform wavelengths.
    FullPrefiltered(FullPrefiltered),
    /// Replicas of the patch, at uniform wavelengths.
    Pq(Pq),
    /// Sum over the lobes of bins that the wavelengths of a direction cross.
    Lobes(Lobes),
    /// Interpolation in a table that contains the window, at wavelengths that are closer where there is more light.
    Warped(Warped),
    /// A table of colours over `(u, v, w)`.
    Baked(Baked),
    /// The order sum of GPU Gems (2004), chapter 8.
    Gems(Gems),
    /// Sum over the orders of a cell with few of them, also under lights with a size.
    Orders(Orders),
}

impl Form {
    /// Chooses all values that the plan leaves to the tool. It is an error, with the reason, if the combination has no
    /// meaning on this surface. Time: arithmetic on the surface's size and height range; for the basis `optimal` a
    /// singular value decomposition, for `gems` a transform.
    pub fn new(variant: &Variant, height: &HeightField) -> Result<Form> {
        use Reconstruction::Prefiltered;
        Ok(match (variant.mode, variant.reconstruction) {
            (Mode::Full, Reconstruction::Window) => {
                Form::FullWindow(FullWindow::new(variant, height)?)
            }
            (Mode::Full, Prefiltered) => {
                Form::FullPrefiltered(FullPrefiltered::new(variant, height)?)
            }
            (Mode::Pq, _) => Form::Pq(Pq::new(variant, height)?),
            (Mode::Adaptive, Reconstruction::Window) => Form::Lobes(Lobes::new(variant, height)?),
            (Mode::Adaptive, Prefiltered) => Form::Warped(Warped::new(variant, height)?),
            (Mode::Baked, _) => Form::Baked(Baked::new(variant, height)?),
            (Mode::Gems, _) => Form::Gems(Gems::new(variant, height)?),
            (Mode::Orders, _) => Form::Orders(Orders::new(variant, height)?),
        })
    }

    /// The form of a texel of a pattern, without its angle. Forms without patterns are as they are.
    #[must_use]
    pub fn patterned(&self, pattern: &Pattern) -> Form {
        match self {
            Form::Orders(form) if *pattern != Pattern::NONE => {
                Form::Orders(form.patterned(pattern))
            }
            other => other.clone(),
        }
    }

    /// Whether its functions have an argument for a pattern.
    pub fn has_pattern(&self) -> bool {
        matches!(self, Form::Orders(form) if form.has_pattern)
    }

    /// The form behind its interface.
    fn get(&self) -> &(dyn Computation + 'static) {
        match self {
            Form::FullWindow(form) => form,
            Form::FullPrefiltered(form) => form,
            Form::Pq(form) => form,
            Form::Lobes(form) => form,
            Form::Warped(form) => form,
            Form::Baked(form) => form,
            Form::Gems(form) => form,
            Form::Orders(form) => form,
        }
    }
}

impl Deref for Form {
    type Target = dyn Computation;

    fn deref(&self) -> &(dyn Computation + 'static) {
        self.get()
    }
}

/// Meaning of `WAVELENGTH_COUNT` at uniform wavelengths.
const WAVELENGTH_COUNT: &str = "number of wavelengths in the sum";

/// Tables of a series at uniform wavelengths.
fn uniform_tables(
    series: &Series,
    filtered: bool,
    (illuminant, wavelengths): (&Illuminant, Wavelengths),
    coat: &Coat,
    on: Ground<'_>,
) -> Vec<TableSpec> {
    let terms = TermsSpec { surface: on.surface.to_owned(), series: series.clone(), filtered };
    let nodes = NodesSpec {
        illuminant: illuminant.clone(),
        wavelengths,
        settings: SettingsSpec::new(on.rotate_deg, &terms, coat.rows.clone()),
    };
    let coefficients = CoefficientsSpec::new(on.surface, series).map(TableSpec::Coefficients);
    [TableSpec::Terms(terms), TableSpec::Nodes(nodes)].into_iter().chain(coefficients).collect()
}

/// Flags and constants of templates under the coherence window.
fn define_window(window: Window, into: &mut Defines) {
    into.flag("COHERENCE_SCALES", window.coherence_scaling == CoherenceScaling::Wavelength);
    into.flag("ENSEMBLE", window.coherence == Coherence::Ensemble);
    let scaled = "wavelength at which the coherence length is stated, µm";
    into.number("REFERENCE_UM", REFERENCE_NM * 1e-3, scaled);
    into.number("COHERENCE_UM", window.coherence_um, "coherence length of the light, µm");
}

/// Constants of templates on the bins of a patch.
fn define_patch([width_um, height_um]: [f64; 2], into: &mut Defines) {
    into.number("PATCH_WIDTH_UM", width_um, "width of the patch that tiles the plane, along x, µm");
    into.number(
        "PATCH_HEIGHT_UM",
        height_um,
        "height of the patch that tiles the plane, along y, µm",
    );
}

/// Constants of templates on the grid of a prefiltered table.
fn define_grid([width_um, height_um]: [f64; 2], into: &mut Defines) {
    let [width, height] = [
        "inverse of the distance in frequency between texels of the terms, along x, µm",
        "inverse of the distance in frequency between texels of the terms, along y, µm",
    ];
    into.number("GRID_WIDTH_UM", width_um, width);
    into.number("GRID_HEIGHT_UM", height_um, height);
}
