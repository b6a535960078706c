//! From a plan to a package: every variant on every surface, all errors in one run.
//!
//! Tables are shared by the variants of a surface that need the same one; their names are hashes of inputs. Work is
//! spread over the current thread pool; the package is the same for any number of threads.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rayon::prelude::*;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::assemble;
use crate::diagnostic::Diagnostic;
use crate::emit::{EmittedFile, emit};
use crate::error::{Error, Stage};
use crate::height::{self, Surface};
use crate::manifest::{SCHEMA_VERSION, Subject, TableEntry, describe, manifest};
use crate::module::Module;
use crate::package::{Compare, JSON_TOLERANCE, Package};
use crate::plan::{Auto, SurfaceSource, SurfaceSpec, Target, Variant};
use crate::resolve::{Resolved, resolve};
use crate::tables::Table;
use crate::template::Sources;

/// Version of this tool, a part of every input hash.
pub const TOOL_VERSION: &str = env!("CARGO_PKG_VERSION");
/// Version of naga, as pinned in `Cargo.toml`.
pub const NAGA_VERSION: &str = "30.0.1";

/// What to generate.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// The surfaces.
    pub surfaces: &'a [SurfaceSpec],
    /// The variants, each for every surface.
    pub variants: &'a [Variant],
    /// Languages.
    pub targets: &'a [Target],
    /// Templates; [`Sources::builtin`] unless a test breaks them.
    pub sources: &'a Sources,
    /// Folder for finished tables, content-addressed; `None`: compute all.
    pub cache: Option<&'a Path>,
    /// Which files are left as they are in the output folder: by path and target.
    pub keep: &'a (dyn Fn(&str, Target) -> bool + Sync),
}

/// The files of a request, not sealed yet, and notes about the surfaces for the user.
pub struct Generated {
    /// Shaders, tables, manifests of variants.
    pub package: Package,
    /// What was filled, clipped, extruded.
    pub notes: Vec<String>,
}

/// Generates everything, or returns every error. `done` is called with the label of each finished step.
pub fn generate(
    request: &Request<'_>,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Generated, Vec<Diagnostic>> {
    let surfaces = load(request)?;
    let pairs: Vec<(&Loaded, &Variant)> =
        surfaces.iter().flat_map(|s| request.variants.iter().map(move |v| (s, v))).collect();
    let built = all_or_errors(pairs.into_par_iter().map(|(s, v)| build(request, s, v)).collect())?;
    let mut package = Package::new();
    let mut written = BTreeSet::new();
    let mut errors = Vec::new();
    for one in built {
        let label = format!("{} {}", one.surface.spec.name, one.variant.name);
        if let Err(error) = one.insert(request, &mut package, &mut written) {
            errors.push(Diagnostic::from(&error).variant(&label));
        }
        done(&label);
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let notes = surfaces
        .iter()
        .flat_map(|s| s.surface.notes.iter().map(|n| format!("{}: {n}", s.spec.name)));
    Ok(Generated { package, notes: notes.collect() })
}

/// The keys of the package's `manifest.json` beside its list of files; the same in any order of the request.
pub fn index(request: &Request<'_>) -> Result<BTreeMap<String, Value>, Error> {
    let mut surfaces = BTreeMap::new();
    for spec in request.surfaces {
        surfaces.insert(spec.name.clone(), json!({ "input_hash": surface_hash(spec)? }));
    }
    let variants: BTreeMap<&str, Value> = request
        .variants
        .iter()
        .map(|v| (v.name.as_str(), json!({ "configuration_hash": v.hash() })))
        .collect();
    let targets: BTreeSet<Target> = request.targets.iter().copied().collect();
    Ok(BTreeMap::from([
        ("schema_version".to_owned(), json!(SCHEMA_VERSION)),
        ("tool_version".to_owned(), json!(TOOL_VERSION)),
        ("naga_version".to_owned(), json!(NAGA_VERSION)),
        ("surfaces".to_owned(), json!(surfaces)),
        ("variants".to_owned(), json!(variants)),
        ("targets".to_owned(), json!(targets)),
    ]))
}

struct Loaded {
    spec: SurfaceSpec,
    surface: Surface,
    hash: String,
}

struct Built<'a> {
    surface: &'a Loaded,
    variant: &'a Variant,
    resolved: Resolved,
    spectrum: Table,
    module: Module,
    files: Vec<EmittedFile>,
}

fn load(request: &Request<'_>) -> Result<Vec<Loaded>, Vec<Diagnostic>> {
    let load = |spec: &SurfaceSpec| -> Result<Loaded, Vec<Diagnostic>> {
        let surface = height::load(spec).map_err(|e| vec![Diagnostic::from(&e)])?;
        let mut errors = BTreeMap::new();
        for variant in request.variants {
            if let Err(error) =
                surface.field.check_pitch(&height::subject(spec), variant.wavelengths.min_nm)
            {
                errors.insert(error.to_string(), Diagnostic::from(&error).variant(&variant.name));
            }
        }
        if !errors.is_empty() {
            return Err(errors.into_values().collect());
        }
        let hash = surface_hash(spec).map_err(|e| vec![Diagnostic::from(&e)])?;
        Ok(Loaded { spec: spec.clone(), surface, hash })
    };
    all_or_errors(request.surfaces.iter().map(load).collect())
}

/// All values, or all errors of all results.
fn all_or_errors<T>(results: Vec<Result<T, Vec<Diagnostic>>>) -> Result<Vec<T>, Vec<Diagnostic>> {
    let (mut values, mut errors) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Ok(value) => values.push(value),
            Err(more) => errors.extend(more),
        }
    }
    if errors.is_empty() { Ok(values) } else { Err(errors) }
}

fn build<'a>(
    request: &Request<'_>,
    surface: &'a Loaded,
    variant: &'a Variant,
) -> Result<Built<'a>, Vec<Diagnostic>> {
    let label = format!("{} {}", surface.spec.name, variant.name);
    let one = |error: Error| vec![Diagnostic::from(&error).variant(&label)];
    let resolved = resolve(variant, &surface.surface.field);
    let spectrum = assemble::spectrum(variant, surface.spec.rotate_deg).map_err(one)?;
    let defines = assemble::defines(variant, &resolved, surface.spec.rotate_deg, spectrum.width);
    let module = assemble::shader(request.sources, &label, &defines)?;
    let mut files = Vec::new();
    for &target in request.targets {
        files.extend(emit(&module, target).map_err(one)?);
    }
    Ok(Built { surface, variant, resolved, spectrum, module, files })
}

impl Built<'_> {
    fn insert(
        self,
        request: &Request<'_>,
        package: &mut Package,
        written: &mut BTreeSet<String>,
    ) -> Result<(), Error> {
        let Built { surface, variant, resolved, spectrum, module, files } = self;
        let name = &surface.spec.name;
        let tables_folder = format!("surfaces/{name}");
        let shader_folder = format!("shaders/{name}/{}", variant.name);
        let terms_id = terms_id(surface, variant);
        let spectrum_id = spectrum_id(surface, variant);
        let terms = assemble::terms_shape(variant, &resolved);
        for (table, id) in [(&terms, &terms_id), (&spectrum, &spectrum_id)] {
            // the variants of a surface share a table, made once
            if !written.insert(format!("{name}/{id}")) {
                continue;
            }
            let bytes = match table.name {
                "terms" => cached(request.cache, id, table.byte_count(), || {
                    assemble::terms(variant, &resolved, &surface.surface.field).bytes()
                }),
                _ => table.bytes(),
            };
            let layer = table.width * table.height * table.format.channels();
            let compare =
                Compare::Table { format: variant.table, tolerance: TABLE_TOLERANCE, layer };
            package.insert(&format!("{tables_folder}/{id}.bin"), bytes, compare)?;
            let description = describe(table, id, &resolved, variant);
            insert_json(package, &format!("{tables_folder}/{id}.json"), &description)?;
        }
        let entry = |table: &Table, id: &str| TableEntry {
            binding: table.name,
            id: id.to_owned(),
            description: format!("../../../{tables_folder}/{id}.json"),
            data: format!("../../../{tables_folder}/{id}.bin"),
        };
        let tables =
            vec![(&terms, entry(&terms, &terms_id)), (&spectrum, entry(&spectrum, &spectrum_id))];
        let input_hash = hash(&json!([surface.hash, variant.hash(), TOOL_VERSION]));
        let subject = Subject { surface: name, variant, resolved: &resolved, tables, input_hash };
        insert_json(
            package,
            &format!("{shader_folder}/manifest.json"),
            &manifest(subject, &module, &files),
        )?;
        for file in files {
            package.insert(
                &format!("{shader_folder}/{}", file.name),
                file.bytes,
                Compare::Bytes,
            )?;
        }
        Ok(())
    }
}

/// Largest difference between processors of a number in a table, relative to the layer's largest: the rounding to 32
/// bits, once more.
const TABLE_TOLERANCE: f64 = 2.4e-7;

/// Finished bytes from the cache, or made and put there. The cache is only a saving: what cannot be read or written is
/// computed.
fn cached(
    folder: Option<&Path>,
    id: &str,
    length: usize,
    make: impl FnOnce() -> Vec<u8>,
) -> Vec<u8> {
    let Some(folder) = folder else { return make() };
    let file = folder.join(format!("{id}.bin"));
    if let Ok(bytes) = std::fs::read(&file)
        && bytes.len() == length
    {
        return bytes;
    }
    let bytes = make();
    let partial = folder.join(format!("{id}.{}.partial", std::process::id()));
    let stored = std::fs::create_dir_all(folder)
        .and_then(|()| std::fs::write(&partial, &bytes))
        .and_then(|()| std::fs::rename(&partial, &file));
    if stored.is_err() {
        let _ = std::fs::remove_file(&partial);
    }
    bytes
}

/// Identity of a term table: everything that its numbers and its size come from.
fn terms_id(surface: &Loaded, variant: &Variant) -> String {
    let terms = match variant.terms {
        Auto::Value(terms) => json!(terms),
        Auto::Auto => json!({ "error": variant.term_error }),
    };
    let radius = match variant.window_radius {
        Auto::Value(radius) => json!(radius),
        Auto::Auto => {
            let optics = &variant.optics;
            json!([optics.coherence_um, optics.coherence_scaling, variant.wavelengths.max_nm])
        }
    };
    let inputs = json!([
        TOOL_VERSION,
        surface.hash,
        variant.basis,
        terms,
        radius,
        variant.wavelengths.min_nm,
        variant.packing,
        variant.table,
    ]);
    format!("terms-{}", &hash(&inputs)[..12])
}

fn spectrum_id(surface: &Loaded, variant: &Variant) -> String {
    let illuminant = &variant.optics.illuminant;
    // a file counts by what is in it
    let illuminant = std::fs::read(illuminant)
        .map_or_else(|_| illuminant.clone(), |bytes| hex(&Sha256::digest(bytes)));
    let inputs = json!([TOOL_VERSION, illuminant, variant.wavelengths, surface.spec.rotate_deg]);
    format!("spectrum-{}", &hash(&inputs)[..12])
}

/// Hash of what a height field is made from: its formula, or its file's bytes with scale and preparation. Neither its
/// name nor its path counts.
fn surface_hash(spec: &SurfaceSpec) -> Result<String, Error> {
    let source = match &spec.source {
        SurfaceSource::Grating(grating) => json!(grating),
        SurfaceSource::File(file) => {
            let bytes = std::fs::read(&file.path).map_err(|e| {
                Error::new(Stage::Height, file.path.display(), "cannot be read").source(e)
            })?;
            json!([
                hex(&Sha256::digest(bytes)),
                file.size_um,
                file.pixel_um,
                file.height_um,
                file.z_unit_um
            ])
        }
    };
    Ok(hash(&json!([source, spec.rotate_deg, spec.level, spec.clip_percent])))
}

fn hash(inputs: &Value) -> String {
    hex(&Sha256::digest(inputs.to_string()))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn insert_json(
    package: &mut Package,
    path: &str,
    value: &impl serde::Serialize,
) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|e| Error::new(Stage::Package, path, "cannot be written as JSON").source(e))?;
    package.insert(path, text + "\n", Compare::Json { tolerance: JSON_TOLERANCE })
}
