//! A variant on a surface: what its template is told, and the tables it reads.

mod lobes;

use std::collections::BTreeMap;

use crate::bake;
use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::height::HeightField;
use crate::module::{Contract, Module, compile_with};
use crate::plan::{
    Coherence, CoherenceScaling, Colour, Mode, Packing, Reconstruction, TableFormat, Variant,
};
use crate::resolve::{NODE_LEVELS, Resolved};
use crate::spectrum::{Sample, Spectrum};
use crate::tables::{
    self, SPECTRUM, Table, grating_table, levels_table, spectrum_table, terms_table,
};
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
        ("FILTERED", variant.filters()),
        ("ENSEMBLE", optics.coherence == Coherence::Ensemble),
        ("HALF", variant.table == TableFormat::F16),
        ("HOIST", variant.hoist),
        ("MODE_ADAPTIVE", variant.mode == Mode::Adaptive),
        ("MODE_BAKED", variant.mode == Mode::Baked),
        ("MODE_FULL", variant.mode == Mode::Full),
        ("MODE_GEMS", variant.mode == Mode::Gems),
        ("MODE_PQ", variant.mode == Mode::Pq),
        ("MONOCHROMATIC", wavelengths == 1),
        ("PREFILTERED", variant.reconstruction == Reconstruction::Prefiltered),
        ("PAIRED", variant.packing == Packing::Paired),
        ("ROTATED", rotate_deg != 0.0),
        ("SHADOWING", optics.shadowing),
        ("TABULATED", resolved.expansion.is_tabulated()),
    ];
    let count = |n: usize| Constant::I32(i32::try_from(n).unwrap_or(i32::MAX));
    let grid_um = resolved.grid.map_or(resolved.patch_um, |grid| grid.size_um);
    let constants = [
        ("CENTRE_COLUMN", count(resolved.bins.r_max)),
        ("CENTRE_ROW", count(resolved.bins.s_max)),
        ("COEFFICIENT_COUNT", count(resolved.coefficient_count)),
        ("COEFFICIENT_ROWS", count(tables::coefficient_rows(&resolved.expansion))),
        ("COHERENCE_UM", Constant::F32(optics.coherence_um)),
        ("COLUMN_COUNT", count(resolved.axes.columns as usize)),
        ("GRID_HEIGHT_UM", Constant::F32(grid_um[1])),
        ("GRID_WIDTH_UM", Constant::F32(grid_um[0])),
        ("LAYER_COUNT", count(resolved.layers as usize)),
        ("LEVEL_COUNT", count(resolved.axes.levels as usize)),
        ("LOBE_COLUMNS", count(resolved.corridor.columns as usize)),
        ("LOBE_ROWS", count(resolved.corridor.rows as usize)),
        ("CANDIDATE_COUNT", count(resolved.corridor.candidates as usize)),
        ("MINOR_COUNT", count(resolved.corridor.minors as usize)),
        ("NODE_BINS", count(resolved.corridor.node_bins as usize)),
        // one wavelength is one node
        ("NODE_COUNT", count((resolved.corridor.nodes as usize).min(wavelengths))),
        ("NODE_LEVELS", count(NODE_LEVELS as usize)),
        ("PAGE_COLUMNS", count(resolved.axes.page_columns() as usize)),
        ("PAGE_COUNT", count(resolved.axes.pages as usize)),
        ("PATCH_HEIGHT_UM", Constant::F32(resolved.patch_um[1])),
        ("PATCH_WIDTH_UM", Constant::F32(resolved.patch_um[0])),
        ("PERIOD_COLUMNS", Constant::F32(f64::from(resolved.periods[0]))),
        ("PERIOD_ROWS", Constant::F32(f64::from(resolved.periods[1]))),
        ("PIXEL_COLUMNS", Constant::F32(f64::from(resolved.pixels[0]))),
        ("PIXEL_ROWS", Constant::F32(f64::from(resolved.pixels[1]))),
        ("REFRACTIVE_INDEX", Constant::F32(optics.refractive_index)),
        ("ROW_COUNT", count(resolved.axes.rows as usize)),
        ("ROW_PACE", Constant::F32(resolved.axes.pace)),
        ("STRETCH", Constant::F32(resolved.axes.stretch)),
        ("TAP_COLUMNS", count(resolved.taps[0] as usize)),
        ("TAP_ROWS", count(resolved.taps[1] as usize)),
        ("WAVELENGTH_COUNT", count(wavelengths)),
        ("WAVELENGTH_MAX_UM", Constant::F32(variant.wavelengths.max_nm * 1e-3)),
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
    let filters = defines.flags.get("FILTERED").is_some_and(|on| *on);
    compile_with(&specialised, sources, name, &Contract::package(filters))
}

/// The tables of a variant in the order of their bindings, unrounded. Time: one two-dimensional transform per two terms.
pub fn tables(
    variant: &Variant,
    resolved: &Resolved,
    height: &HeightField,
    rotate_deg: f64,
) -> Result<Vec<Table>> {
    let mut all = shapes(variant, resolved, rotate_deg)?;
    for table in all.iter_mut().filter(|table| table.binding == tables::TERMS) {
        *table = terms(variant, resolved, height, &|_| ())?;
    }
    Ok(all)
}

/// The same with the term table's texels left out.
pub fn shapes(variant: &Variant, resolved: &Resolved, rotate_deg: f64) -> Result<Vec<Table>> {
    if variant.mode == Mode::Baked {
        let shape = bake::shape(&resolved.axes, variant.table);
        let mut all = vec![Table { filtered: variant.filters(), ..shape }];
        if rotate_deg != 0.0 {
            all.push(tables::rotation_table(rotate_deg));
        }
        return Ok(all);
    }
    let mut all = Vec::new();
    if variant.mode != Mode::Gems {
        let shape = tables::terms_shape(
            resolved.bins,
            resolved.expansion.terms as usize,
            variant.packing,
            variant.table,
        );
        all.push(Table { filtered: variant.filters(), ..shape });
    }
    all.push(spectrum(variant, resolved, rotate_deg)?);
    if variant.mode != Mode::Gems && resolved.expansion.is_tabulated() {
        all.push(tables::coefficients_table(&resolved.expansion, resolved.coefficient_count));
    }
    Ok(all)
}

/// The term table or the table of colours, unrounded. `baked` is called with the columns of the latter that were finished
/// since the last call, from any thread.
pub fn terms(
    variant: &Variant,
    resolved: &Resolved,
    height: &HeightField,
    baked: &(dyn Fn(usize) + Sync),
) -> Result<Table> {
    if variant.mode == Mode::Baked {
        let Variant { optics, wavelengths, .. } = variant;
        let colours = bake::bake(height, optics, wavelengths, resolved.axes, baked)?;
        let table = bake::table(&bake::sharpen(colours), variant.table);
        return Ok(Table { filtered: variant.filters(), ..table });
    }
    let terms = Terms::new(height, &resolved.expansion, resolved.bins, resolved.grid);
    let table = terms_table(&terms, variant.packing, variant.table, resolved.scale);
    Ok(Table { filtered: variant.filters(), ..table })
}

/// The spectrum table, unrounded.
fn spectrum(variant: &Variant, resolved: &Resolved, rotate_deg: f64) -> Result<Table> {
    let samples = match variant.mode {
        Mode::Gems => return Ok(grating_table(resolved.grating_um, rotate_deg)),
        Mode::Baked => return Ok(tables::rotation_table(rotate_deg)),
        Mode::Full | Mode::Pq => {
            Spectrum::new(&variant.optics.illuminant)?.samples(&variant.wavelengths)
        }
        Mode::Adaptive if !resolved.node_counts.is_empty() => {
            let levels = Spectrum::new(&variant.optics.illuminant)?
                .warped_samples(&variant.wavelengths, &resolved.node_counts);
            return Ok(levels_table(&levels, rotate_deg, resolved.scale));
        }
        Mode::Adaptive => {
            let samples =
                Spectrum::new(&variant.optics.illuminant)?.wavenumber_samples(&variant.wavelengths);
            if samples.len() == 1 {
                samples
            } else {
                return Ok(lobes::lobes_table(&samples, variant, resolved, rotate_deg));
            }
        }
    };
    Ok(spectrum_table(&samples, rotate_deg, resolved.scale))
}

/// A spectrum table of one wavelength, nm, with weight 1: the shader then returns `C·|P|²` there.
pub fn single_wavelength(resolved: &Resolved, lambda_nm: f64, rotate_deg: f64) -> Table {
    spectrum_table(&[Sample { lambda_nm, xyz: [1.0; 3] }], rotate_deg, resolved.scale)
}

/// Nodes of the spectrum among a variant's tables.
pub fn node_count(tables: &[Table]) -> usize {
    tables.iter().find(|t| t.binding == SPECTRUM).map_or(0, |t| t.width)
}
