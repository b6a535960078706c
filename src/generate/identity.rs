//! Names of computed things: hashes of everything that their numbers come from.

use serde_json::{Value, json};

use crate::error::{Error, Stage};
use crate::package::sha256;
use crate::plan::{
    Auto, Basis, Mode, Optics, Reconstruction, SurfaceSource, SurfaceSpec, TableFormat, Variant,
    Wavelengths,
};
use crate::tables::{COEFFICIENTS, TERMS, Table};

use super::TOOL_VERSION;

/// Identity of a table of a variant on a surface with that hash.
pub(super) fn table_id(
    table: &Table,
    spec: &SurfaceSpec,
    surface_hash: &str,
    variant: &Variant,
) -> String {
    match table.binding {
        TERMS => terms_id(surface_hash, variant),
        COEFFICIENTS => coefficients_id(surface_hash, variant),
        _ => spectrum_id(spec, surface_hash, variant),
    }
}

/// Identity of the probes' directions and exact colours: of all optics, only the conversion to RGB has no part in them.
pub(super) fn exact_id(surface_hash: &str, optics: &Optics) -> String {
    let Optics { coherence_um, coherence, coherence_scaling, refractive_index, shadowing, .. } =
        optics;
    let illuminant = illuminant(optics);
    let inputs = json!([
        TOOL_VERSION,
        surface_hash,
        coherence_um,
        coherence,
        coherence_scaling,
        refractive_index,
        shadowing,
        illuminant
    ]);
    format!("exact-{}", hash(&inputs))
}

/// Identity of the probes' expected colours.
pub(super) fn expected_id(surface_hash: &str, variant: &Variant) -> String {
    let inputs = json!([exact_id(surface_hash, &variant.optics), variant.hash()]);
    format!("expected-{}", hash(&inputs))
}

/// Identity of a term table: everything that its numbers and its size come from.
fn terms_id(surface_hash: &str, variant: &Variant) -> String {
    if variant.mode == Mode::Baked {
        let Optics { coherence_um, coherence, coherence_scaling, .. } = &variant.optics;
        let Wavelengths { min_nm, max_nm, .. } = variant.wavelengths;
        let inputs = json!([
            [TOOL_VERSION, surface_hash, min_nm, max_nm, variant.table],
            [variant.bake_error, variant.bake_mib],
            [coherence_um, coherence, coherence_scaling, illuminant(&variant.optics)],
        ]);
        return format!("colours-{}", &hash(&inputs)[..12]);
    }
    let radius = match (variant.mode, variant.window_radius) {
        _ if is_prefiltered(variant) => json!(["prefiltered", variant.optics.coherence_um]),
        (Mode::Adaptive, _) => {
            let optics = &variant.optics;
            let max_nm = variant.wavelengths.max_nm;
            json!(["adaptive", optics.coherence_um, optics.coherence_scaling, max_nm])
        }
        (_, Auto::Value(radius)) => json!(radius),
        (Mode::Pq, Auto::Auto) => json!(["pq", variant.periods, variant.optics.coherence_um]),
        (_, Auto::Auto) => {
            let optics = &variant.optics;
            json!([optics.coherence_um, optics.coherence_scaling, variant.wavelengths.max_nm])
        }
    };
    let inputs = json!([
        TOOL_VERSION,
        surface_hash,
        variant.basis,
        term_count(variant),
        radius,
        variant.wavelengths.min_nm,
        variant.packing,
        variant.table,
    ]);
    format!("terms-{}", &hash(&inputs)[..12])
}

/// Identity of a table of coefficients.
fn coefficients_id(surface_hash: &str, variant: &Variant) -> String {
    let min_nm = variant.wavelengths.min_nm;
    let mut inputs =
        json!([TOOL_VERSION, surface_hash, variant.basis, term_count(variant), min_nm]);
    if is_prefiltered(variant) {
        inputs = json!([inputs, "nearest"]);
    }
    format!("coefficients-{}", &hash(&inputs)[..12])
}

fn is_prefiltered(variant: &Variant) -> bool {
    variant.reconstruction == Reconstruction::Prefiltered
}

fn term_count(variant: &Variant) -> Value {
    match variant.terms {
        // what counts as faint light
        Auto::Value(terms) if variant.basis == Basis::Optimal => {
            json!([terms, illuminant(&variant.optics), variant.wavelengths.max_nm])
        }
        Auto::Value(terms) => json!(terms),
        Auto::Auto => json!({ "error": variant.term_error }),
    }
}

fn spectrum_id(spec: &SurfaceSpec, surface_hash: &str, variant: &Variant) -> String {
    let illuminant = illuminant(&variant.optics);
    let rotate_deg = spec.rotate_deg;
    let Wavelengths { min_nm, max_nm, .. } = variant.wavelengths;
    let mut inputs = match variant.mode {
        Mode::Full | Mode::Pq => json!([TOOL_VERSION, illuminant, variant.wavelengths, rotate_deg]),
        Mode::Adaptive if is_prefiltered(variant) => json!([
            TOOL_VERSION,
            "warped",
            surface_hash,
            variant.optics.coherence_um,
            illuminant,
            min_nm,
            max_nm,
            rotate_deg
        ]),
        // the height range decides about the lobes, the coherence length about the patch only
        Mode::Adaptive => {
            let scaling = variant.optics.coherence_scaling;
            json!([
                TOOL_VERSION,
                "lobes",
                illuminant,
                min_nm,
                max_nm,
                rotate_deg,
                surface_hash,
                scaling
            ])
        }
        Mode::Gems => json!([TOOL_VERSION, "gems", surface_hash]),
        Mode::Baked => json!([TOOL_VERSION, "rotation", rotate_deg]),
    };
    if variant.table == TableFormat::F16 && variant.mode != Mode::Baked {
        // the scales of the terms are in it
        inputs = json!([inputs, terms_id(surface_hash, variant)]);
    }
    format!("spectrum-{}", &hash(&inputs)[..12])
}

/// Hash of what a height field is made from: its formula, or its file's bytes with scale and preparation. Neither its
/// name nor its path counts.
pub(super) fn surface_hash(spec: &SurfaceSpec) -> Result<String, Error> {
    let source = match &spec.source {
        SurfaceSource::Grating(grating) => json!(grating),
        SurfaceSource::File(file) => {
            let bytes = std::fs::read(&file.path).map_err(|e| {
                Error::new(Stage::Height, file.path.display(), "cannot be read").source(e)
            })?;
            json!([sha256(&bytes), file.size_um, file.pixel_um, file.height_um, file.z_unit_um])
        }
    };
    Ok(hash(&json!([source, spec.rotate_deg, spec.level, spec.clip_percent])))
}

pub(super) fn hash(inputs: &Value) -> String {
    sha256(inputs.to_string().as_bytes())
}

/// Of an illuminant: its name, or of a file what is in it.
pub(super) fn illuminant(optics: &Optics) -> String {
    let name = &optics.illuminant;
    std::fs::read(name).map_or_else(|_| name.clone(), |bytes| sha256(&bytes))
}
