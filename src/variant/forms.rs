//! One file for each way to compute.

mod baked;
mod full_prefiltered;
mod full_window;
mod gems;
mod lobes;
mod pq;
mod warped;

use crate::defines::Defines;
use crate::plan::{Coherence, CoherenceScaling, Illuminant, Wavelengths, Window};
use crate::tables::{CoefficientsSpec, NodesSpec, Series, SettingsSpec, TableSpec, TermsSpec};

use super::Ground;

pub use baked::Baked;
pub use full_prefiltered::FullPrefiltered;
pub use full_window::FullWindow;
pub use gems::Gems;
pub use lobes::Lobes;
pub use pq::Pq;
pub use warped::Warped;

/// Tables of a series at uniform wavelengths.
fn uniform_tables(
    series: &Series,
    filtered: bool,
    illuminant: &Illuminant,
    wavelengths: Wavelengths,
    on: Ground<'_>,
) -> Vec<TableSpec> {
    let terms = TermsSpec { surface: on.surface.to_owned(), series: series.clone(), filtered };
    let nodes = NodesSpec {
        illuminant: illuminant.clone(),
        wavelengths,
        settings: SettingsSpec::new(on.rotate_deg, &terms),
    };
    let coefficients = CoefficientsSpec::new(on.surface, series).map(TableSpec::Coefficients);
    [TableSpec::Terms(terms), TableSpec::Nodes(nodes)].into_iter().chain(coefficients).collect()
}

/// What templates under the coherence window are told.
fn define_window(window: Window, into: &mut Defines) {
    into.flag("COHERENCE_SCALES", window.coherence_scaling == CoherenceScaling::Wavelength);
    into.flag("ENSEMBLE", window.coherence == Coherence::Ensemble);
    into.number("COHERENCE_UM", window.coherence_um);
}

/// What templates on the bins of a patch are told.
fn define_patch([width_um, height_um]: [f64; 2], into: &mut Defines) {
    into.number("PATCH_WIDTH_UM", width_um);
    into.number("PATCH_HEIGHT_UM", height_um);
}

/// What templates on a grid of its own are told.
fn define_grid([width_um, height_um]: [f64; 2], into: &mut Defines) {
    into.number("GRID_WIDTH_UM", width_um);
    into.number("GRID_HEIGHT_UM", height_um);
}
