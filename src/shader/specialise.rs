//! A variant on a surface: flags and constants of its templates, its shader, and its tables.

use crate::defines::Defines;
use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::plan::{Colour, Mode, Variant};
use crate::shader::module::{Contract, Module, compile_with};
use crate::shader::template::{Sources, specialise};
use crate::surface::HeightField;
use crate::tables::{SPECTRUM, Table};
use crate::variant::{Form, Ground};

/// The root template of every shader.
pub const ROOT: &str = "shader";

/// Flags that forms may set.
const FLAGS: [&str; 20] = [
    "COHERENCE_SCALES",
    "DISC",
    "ENSEMBLE",
    "ENVIRONMENT",
    "EVEN_LEVELS",
    "HALF",
    "LAMPS",
    "LONG_LOOPS",
    "MONOCHROMATIC",
    "PAIRED",
    "PREFILTERED",
    "OUTWARD",
    "PATH",
    "PATTERN",
    "RECTANGLE",
    "SIZED",
    "SPECTRAL",
    "SPREAD",
    "TABULATED",
    "THESIS_LOOP",
];

/// Number of texels of the term table up to which each is read in a step of a loop of its own. OpenGL of llvmpipe ends the
/// loops of a shader after 65,535 steps in all. With more texels in a step a shader has fewer steps, but it is up to half
/// slower on that driver.
const MAX_STEPS: u64 = 1 << 15;

/// Number of texels of the term table that a step of the innermost loop reads.
pub fn texels_per_step(form: &Form) -> u64 {
    if form.cost().term_fetches > MAX_STEPS { 4 } else { 1 }
}

/// Flags and constants of the templates. All numbers are configured numbers, counts or sizes. They never come from a
/// transform or a transcendental function, whose results differ between processors, while the text must be the same
/// everywhere. `wavelengths`: number of nodes of the spectrum table.
pub fn defines(variant: &Variant, form: &Form, rotate_deg: f64, wavelengths: usize) -> Defines {
    let mut defines = Defines::default();
    for flag in FLAGS {
        defines.flag(flag, false);
    }
    for mode in Mode::all() {
        let flag = format!("MODE_{}", mode.as_str().to_ascii_uppercase());
        defines.flag(&flag, mode == variant.mode);
    }
    defines.flag("COLOUR_THESIS", variant.optics.colour == Colour::Thesis);
    defines.flag("FILTERED", form.filters());
    defines.flag("ROTATED", rotate_deg != 0.0);
    form.matter().define(&mut defines);
    defines.flag("LONG_LOOPS", texels_per_step(form) > 1);
    form.define(wavelengths, &mut defines);
    defines.flag("TURNED", rotate_deg != 0.0 || form.has_pattern());
    let rows = "rows of the table of arguments for a row of the picture";
    defines.count("ARGUMENT_ROWS", if form.has_pattern() { 6 } else { 5 }, rows);
    defines
}

/// Specialises, parses, validates and lints the shader of a variant on a surface.
pub fn shader(
    sources: &Sources,
    name: &str,
    form: &Form,
    defines: &Defines,
) -> std::result::Result<Module, Vec<Diagnostic>> {
    let named = |all: Vec<Diagnostic>| all.into_iter().map(|d| d.variant(name)).collect::<Vec<_>>();
    let specialised = specialise(sources, ROOT, defines).map_err(named)?;
    let functions = form.functions();
    let filters = form.filters() || functions.iter().any(|function| function.host().is_some());
    let contract = Contract::package(&functions, filters);
    compile_with(&specialised, sources, name, &contract)
}

/// The tables of a form in the order of their bindings, unrounded. Time: one two-dimensional transform per two terms,
/// or the baking of the colours.
pub fn tables(form: &Form, height: &HeightField, rotate_deg: f64) -> Result<Vec<Table>> {
    let specs = form.tables(Ground { surface: "", rotate_deg });
    specs.iter().map(|spec| spec.compute(height)).collect()
}

/// The same tables without texels.
pub fn shapes(form: &Form, rotate_deg: f64) -> Vec<Table> {
    form.tables(Ground { surface: "", rotate_deg }).iter().map(|spec| spec.shape()).collect()
}

/// Number of nodes of the spectrum table among a variant's tables.
pub fn node_count(tables: &[Table]) -> usize {
    tables.iter().find(|t| t.binding == SPECTRUM).map_or(0, |t| t.width)
}
