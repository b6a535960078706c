//! One file for each way to compute.

mod baked;
mod full_prefiltered;
mod full_window;
mod gems;
mod lobes;
mod pq;
mod warped;

use crate::defines::Defines;
use crate::optics::REFERENCE_NM;
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

/// Meaning of `WAVELENGTH_COUNT` at uniform wavelengths.
const WAVELENGTH_COUNT: &str = "number of wavelengths in the sum";

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

/// Constants of templates on a grid of its own.
fn define_grid([width_um, height_um]: [f64; 2], into: &mut Defines) {
    let [width, height] = [
        "texels of the terms are 1 / this apart in frequency along x, µm",
        "texels of the terms are 1 / this apart in frequency along y, µm",
    ];
    into.number("GRID_WIDTH_UM", width_um, width);
    into.number("GRID_HEIGHT_UM", height_um, height);
}
