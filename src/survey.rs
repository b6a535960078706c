//! Survey of a surface: the facts that users need first, and three pictures.

mod canvas;
mod font;
mod heights;
mod matter;
pub mod memory;
mod plot;
mod spectrum;
mod window;

use serde::Serialize;

use crate::error::Result;
use crate::field::orders::OrderSum;
use crate::input::SurfaceInput;
use crate::optics::Matter;
use crate::plan::{Basis, Plan, SurfaceSource, SurfaceSpec, Wavelengths};
use crate::surface::facts::{Facts, Periods, facts, periods};
use crate::surface::{self, HeightField, Origin};
use crate::tables::Series;
use crate::tables::basis::Expansion;
use crate::variant::{Cost, Form};

pub use heights::height_picture;
pub use matter::{MatterFacts, reflectance_picture};
pub use spectrum::spectrum_picture;
pub use window::Window;

/// Errors of the phase function for which terms are counted.
pub const TERM_ERRORS: [f64; 3] = [1e-1, 1e-2, 1e-3];

/// Shortest wavelength if the plan has no variants, nm.
const SHORTEST_NM: f64 = 380.0;

/// Facts about a surface that are known before anything is generated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Survey {
    /// Size, relief, tilt.
    #[serde(flatten)]
    pub facts: Facts,
    /// Rotation that is applied to the directions later, degrees. The survey describes the surface without it.
    pub rotate_deg: f64,
    /// Step between neighbouring heights of an integer file, µm.
    pub step_um: Option<f64>,
    /// Void pixels of the file.
    pub void_pixels: usize,
    /// Share of the file's pixels that are void.
    pub void_share: f64,
    /// Shortest wavelength of the plan's variants, nm; 380 if there are none.
    pub wanted_nm: f64,
    /// Maximum pitch for this wavelength, µm.
    pub wanted_pitch_um: f64,
    /// Periods of the heights.
    pub periods: Periods,
    /// Number of terms that each basis needs.
    pub terms: Vec<TermCounts>,
    /// The coherence window in comparison with the patch.
    pub window: Window,
    /// What it is made of under the surface's optics.
    pub matter: MatterFacts,
    /// Radiance under a white sky of radiance 1 under the surface's optics, X, Y, Z, at 0, 30, 60 and 75 degrees from the
    /// normal. `None` where its orders need more memory than the tool allows.
    pub white_sky: Option<[[f64; 3]; 4]>,
    /// Cost of the plan's variants on this surface.
    pub variants: Vec<VariantCost>,
    /// Notes about changes of the heights.
    pub notes: Vec<String>,
}

/// Numbers of terms of one basis for each of [`TERM_ERRORS`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TermCounts {
    /// Which basis.
    pub basis: Basis,
    /// Bounds of the error of `exp(i z h)`, the same as [`TERM_ERRORS`].
    pub errors: [f64; 3],
    /// Numbers of terms for the surface as it is.
    pub terms: [u32; 3],
    /// Numbers of terms after subtraction of its least-squares plane (`level = "plane"`).
    pub levelled: [u32; 3],
    /// Numbers of terms if its outliers are also clipped (`clip_percent = 0.1`).
    pub trimmed: [u32; 3],
}

/// The cost of a variant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VariantCost {
    /// The variant's name.
    pub name: String,
    /// Number of terms, if the variant sums a series.
    pub terms: Option<u32>,
    /// Number of bins to each side of the nearest one, if the variant has such a number.
    pub window_radius: Option<u32>,
    /// Static cost of a lit pixel.
    #[serde(flatten)]
    pub cost: Cost,
}

/// Reads or synthesises a surface of a plan and measures it. Also returns the heights, for the pictures.
pub fn survey(plan: &Plan, spec: &SurfaceSpec) -> Result<(Survey, HeightField)> {
    let input = SurfaceInput::read(spec)?;
    let (surface::Surface { field, notes }, origin) = input.surface_with_origin()?.clone();
    let mut notes = notes;
    let Origin { step_um, void_pixels, file_pixels } = origin;
    let facts = facts(&field, &format!("surface {}", spec.name))?;
    let is_synthetic = matches!(spec.source, SurfaceSource::Grating(_));
    let tiled = facts.joins.map(|joins| joins || is_synthetic);
    let here: Vec<_> = plan.variants.iter().filter(|v| v.is_for(&spec.name)).collect();
    let shortest = here.iter().map(|v| v.wavelengths.min_nm).reduce(f64::min);
    let wanted_nm = shortest.unwrap_or(SHORTEST_NM);
    let longest = here.iter().map(|v| v.wavelengths.max_nm).reduce(f64::max);
    let range_nm = [wanted_nm, longest.unwrap_or(Wavelengths::VISIBLE_NM[1])];
    let mut variants = Vec::new();
    for variant in here.into_iter().filter_map(|variant| variant.on(spec)) {
        let laid = variant.and_then(|v| Form::new(&v, &field).map(|form| (v, form)));
        match laid {
            Ok((variant, form)) => variants.push(VariantCost {
                name: variant.name,
                terms: form.series().map(Series::terms),
                window_radius: form.window_radius(),
                cost: form.cost(),
            }),
            Err(reason) => notes.push(format!("left out: {reason}")),
        }
    }
    let optics = spec.optics.over(&plan.optics);
    let matter = Matter::new(&optics)?;
    let phases = (matter.least_z(range_nm), matter.phase_min_nm(range_nm));
    let white_sky = match OrderSum::has_white_sky(&field, &matter) {
        true => Some(OrderSum::new(&field, spec.rotate_deg, &optics)?.white_sky()),
        false => None,
    };
    let inspection = Survey {
        matter: MatterFacts::new(&optics, &matter),
        white_sky,
        rotate_deg: spec.rotate_deg,
        step_um,
        void_pixels,
        void_share: void_pixels as f64 / file_pixels.max(1) as f64,
        wanted_nm,
        wanted_pitch_um: wanted_nm / 4000.0,
        periods: periods(&field, tiled),
        terms: [Basis::Taylor, Basis::TaylorZero, Basis::Chebyshev, Basis::Optimal]
            .map(|basis| term_counts(basis, &facts, &field, phases))
            .into_iter()
            .collect::<Result<_>>()?,
        window: Window::new(&optics, &facts, is_synthetic),
        variants,
        notes,
        facts,
    };
    Ok((inspection, field))
}

fn term_counts(
    basis: Basis,
    facts: &Facts,
    field: &HeightField,
    (least_z, min_nm): (f64, f64),
) -> Result<TermCounts> {
    let counts = |peak_to_valley_um: f64| -> Result<[u32; 3]> {
        // assumes that levelling and clipping do not change the shape of the relief
        let share = if facts.peak_to_valley_um > 0.0 {
            peak_to_valley_um / facts.peak_to_valley_um
        } else {
            1.0
        };
        let heights_um = field.heights_um().iter().map(|h| share * h).collect();
        let (columns, rows) = (field.columns(), field.rows());
        let (pitch_x_um, pitch_y_um) = (field.pitch_x_um(), field.pitch_y_um());
        let scaled = HeightField::new(columns, rows, pitch_x_um, pitch_y_um, heights_um)?;
        let expansion = Expansion::over((least_z, min_nm), min_nm, basis, 1, &scaled);
        Ok(TERM_ERRORS.map(|error| expansion.clone().with_error(error).terms))
    };
    Ok(TermCounts {
        basis,
        errors: TERM_ERRORS,
        terms: counts(facts.peak_to_valley_um)?,
        levelled: counts(facts.levelled_peak_to_valley_um)?,
        trimmed: counts(facts.trimmed_peak_to_valley_um)?,
    })
}
