//! A variant on a surface: what its template is told, and the tables it reads.

use std::collections::BTreeMap;

use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::height::HeightField;
use crate::module::{Module, compile};
use crate::plan::{Coherence, CoherenceScaling, Colour, Packing, Variant};
use crate::resolve::Resolved;
use crate::spectrum::{Sample, Spectrum};
use crate::tables::{self, Table, spectrum_table, terms_table};
use crate::template::{Constant, Defines, Sources, specialise};
use crate::terms::Terms;

/// The root template of every shader.
pub const ROOT: &str = "shader";

/// What the templates are told: configured numbers, counts and sizes; no number that a transform or a transcendental
/// function computed, since those differ between processors and the text must not.
pub fn defines(
    variant: &Variant,
    resolved: &Resolved,
    rotate_deg: f64,
    wavelengths: usize,
) -> Defines {
    let optics = &variant.optics;
    let flags = [
        ("COHERENCE_SCALES", optics.coherence_scaling == CoherenceScaling::Wavelength),
        ("COLOUR_THESIS", optics.colour == Colour::Thesis),
        ("ENSEMBLE", optics.coherence == Coherence::Ensemble),
        ("HOIST", variant.hoist),
        ("PAIRED", variant.packing == Packing::Paired),
        ("ROTATED", rotate_deg != 0.0),
        ("SHADOWING", optics.shadowing),
    ];
    let count = |n: usize| Constant::I32(i32::try_from(n).unwrap_or(i32::MAX));
    let constants = [
        ("CENTRE_COLUMN", count(resolved.bins.r_max)),
        ("CENTRE_ROW", count(resolved.bins.s_max)),
        ("COHERENCE_UM", Constant::F32(optics.coherence_um)),
        ("LAYER_COUNT", count(resolved.layers as usize)),
        ("PATCH_HEIGHT_UM", Constant::F32(resolved.patch_um[1])),
        ("PATCH_WIDTH_UM", Constant::F32(resolved.patch_um[0])),
        ("REFRACTIVE_INDEX", Constant::F32(optics.refractive_index)),
        ("WAVELENGTH_COUNT", count(wavelengths)),
        ("WAVELENGTH_MIN_UM", Constant::F32(variant.wavelengths.min_nm * 1e-3)),
        ("WINDOW_RADIUS", count(resolved.window_radius as usize)),
    ];
    Defines {
        flags: flags.map(|(name, on)| (name.to_owned(), on)).into(),
        constants: constants
            .map(|(name, value)| (name.to_owned(), value))
            .into_iter()
            .collect::<BTreeMap<_, _>>(),
    }
}

/// Specialises, parses, validates and lints the shader of a variant on a surface.
pub fn shader(
    sources: &Sources,
    name: &str,
    defines: &Defines,
) -> std::result::Result<Module, Vec<Diagnostic>> {
    let named = |all: Vec<Diagnostic>| all.into_iter().map(|d| d.variant(name)).collect::<Vec<_>>();
    let specialised = specialise(sources, ROOT, defines).map_err(named)?;
    compile(&specialised, sources, name)
}

/// The term table, unrounded. Time: one two-dimensional transform per two terms.
pub fn terms(variant: &Variant, resolved: &Resolved, height: &HeightField) -> Table {
    terms_table(
        &Terms::new(height, &resolved.expansion, resolved.bins),
        variant.packing,
        variant.table,
    )
}

/// The term table without its texels.
pub fn terms_shape(variant: &Variant, resolved: &Resolved) -> Table {
    tables::terms_shape(
        resolved.bins,
        resolved.expansion.terms as usize,
        variant.packing,
        variant.table,
    )
}

/// The spectrum table, unrounded.
pub fn spectrum(variant: &Variant, rotate_deg: f64) -> Result<Table> {
    let spectrum = Spectrum::new(&variant.optics.illuminant)?;
    Ok(spectrum_table(&spectrum.samples(&variant.wavelengths), rotate_deg))
}

/// A spectrum table of one wavelength, nm, with weight 1: the shader then returns `C·|P|²` there.
pub fn single_wavelength(lambda_nm: f64, rotate_deg: f64) -> Table {
    spectrum_table(&[Sample { lambda_nm, xyz: [1.0; 3] }], rotate_deg)
}
