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
use crate::bindings;
use crate::diagnostic::Diagnostic;
use crate::emit::{EmittedFile, emit};
use crate::error::{Error, Stage};
use crate::height::{self, HeightField, Surface};
use crate::manifest::{SCHEMA_VERSION, Subject, TableEntry, describe, manifest};
use crate::module::Module;
use crate::package::{Compare, JSON_TOLERANCE, Package};
use crate::plan::{
    Auto, Mode, SurfaceSource, SurfaceSpec, TableFormat, Target, Variant, Wavelengths,
};
use crate::resolve::{Resolved, resolve};
use crate::tables::{TERMS, Table};
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
    /// What was filled, clipped, extruded; and the gaps.
    pub notes: Vec<String>,
    /// Variants that a surface has no use for.
    pub gaps: Vec<Gap>,
}

/// A variant that cannot be built on a surface, and why: a listed fact, not a failure of the others.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Gap {
    /// Name of the surface.
    pub surface: String,
    /// Name of the variant.
    pub variant: String,
    /// Why.
    pub reason: String,
}

/// Generates everything, or returns every error. `done` is called with the label of each finished step.
pub fn generate(
    request: &Request<'_>,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Generated, Vec<Diagnostic>> {
    let surfaces = load(request)?;
    let mut gaps = Vec::new();
    let mut pairs = Vec::new();
    for surface in &surfaces {
        for variant in request.variants {
            match gap(&surface.spec, variant, &surface.surface.field) {
                Some(gap) => gaps.push(gap),
                None => pairs.push((surface, variant)),
            }
        }
    }
    if let (true, Some(gap)) = (pairs.is_empty(), gaps.first()) {
        let subject = format!("{} {}", gap.surface, gap.variant);
        let error = Error::new(
            Stage::Compute,
            subject,
            format!("nothing is left to generate: {}", gap.reason),
        );
        return Err(vec![Diagnostic::from(&error)]);
    }
    let built = pairs.into_par_iter().map(|(s, v)| build(request, s, v));
    let built = all_or_errors(built.collect())?;
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
    let left_out = gaps.iter().map(|gap| format!("{}: left out: {}", gap.surface, gap.reason));
    Ok(Generated { package, notes: notes.chain(left_out).collect(), gaps })
}

fn gap(spec: &SurfaceSpec, variant: &Variant, field: &HeightField) -> Option<Gap> {
    let reason = resolve(variant, field).err()?.to_string();
    Some(Gap { surface: spec.name.clone(), variant: variant.name.clone(), reason })
}

/// The keys of the package's `manifest.json` beside its list of files; the same in any order of the request.
pub fn index(request: &Request<'_>) -> Result<BTreeMap<String, Value>, Error> {
    let (mut surfaces, mut gaps) = (BTreeMap::new(), Vec::new());
    for spec in request.surfaces {
        surfaces.insert(spec.name.clone(), json!({ "input_hash": surface_hash(spec)? }));
        let field = height::load(spec)?.field;
        gaps.extend(request.variants.iter().filter_map(|v| gap(spec, v, &field)));
    }
    gaps.sort_by(|a, b| (&a.surface, &a.variant).cmp(&(&b.surface, &b.variant)));
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
        ("gaps".to_owned(), json!(gaps)),
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
    tables: Vec<Table>,
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
    let resolved = resolve(variant, &surface.surface.field).map_err(one)?;
    let rotate_deg = surface.spec.rotate_deg;
    let tables = assemble::shapes(variant, &resolved, rotate_deg).map_err(one)?;
    let nodes = assemble::node_count(&tables);
    let defines = assemble::defines(variant, &resolved, rotate_deg, nodes);
    let module = assemble::shader(request.sources, &label, &defines)?;
    let mut files = Vec::new();
    for &target in request.targets {
        files.extend(emit(&module, target).map_err(one)?);
    }
    Ok(Built { surface, variant, resolved, tables, module, files })
}

impl Built<'_> {
    fn insert(
        self,
        request: &Request<'_>,
        package: &mut Package,
        written: &mut BTreeSet<String>,
    ) -> Result<(), Error> {
        let Built { surface, variant, resolved, tables, module, files } = self;
        let name = &surface.spec.name;
        let tables_folder = format!("surfaces/{name}");
        let shader_folder = format!("shaders/{name}/{}", variant.name);
        let named: Vec<(&Table, String)> =
            tables.iter().map(|table| (table, table_id(table, surface, variant))).collect();
        for (table, id) in &named {
            // the variants of a surface share a table, made once
            if !written.insert(format!("{name}/{id}")) {
                continue;
            }
            let bytes = match table.binding {
                TERMS => cached(request.cache, id, table.byte_count(), || {
                    assemble::terms(variant, &resolved, &surface.surface.field).bytes()
                }),
                _ => table.bytes(),
            };
            let layer = table.width * table.height * table.format.channels();
            let (format, tolerance) = match table.format.number_bytes() {
                2 => (TableFormat::F16, HALF_TOLERANCE),
                _ => (TableFormat::F32, TABLE_TOLERANCE),
            };
            let compare = Compare::Table { format, tolerance, layer };
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
        let tables = named.iter().map(|(table, id)| (*table, entry(table, id))).collect();
        let input_hash = hash(&json!([surface.hash, variant.hash(), TOOL_VERSION]));
        let subject = Subject { surface: name, variant, resolved: &resolved, tables, input_hash };
        let manifest = manifest(subject, &module, &files);
        insert_json(package, &format!("{shader_folder}/manifest.json"), &manifest)?;
        let shapes: Vec<&Table> = named.iter().map(|(table, _)| *table).collect();
        let rust = bindings::rust(&manifest, &shapes)?;
        package.insert(&format!("{shader_folder}/{}", bindings::FILE), rust, Compare::Bytes)?;
        // two targets may share a file, as those of GLSL share the function form
        let pathed = files.into_iter().map(|file| (format!("{shader_folder}/{}", file.name), file));
        let fresh = pathed.filter(|(path, file)| !(request.keep)(path, file.target));
        let fresh: BTreeMap<String, Vec<u8>> =
            fresh.map(|(path, file)| (path, file.bytes)).collect();
        for (path, bytes) in fresh {
            package.insert(&path, bytes, Compare::Bytes)?;
        }
        Ok(())
    }
}

/// Largest difference between processors of a number in a table, relative to the layer's largest: the rounding to 32
/// bits, once more.
const TABLE_TOLERANCE: f64 = 2.4e-7;
/// The same of a table of 16-bit floats.
const HALF_TOLERANCE: f64 = 1e-3;

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

fn table_id(table: &Table, surface: &Loaded, variant: &Variant) -> String {
    if table.binding == TERMS { terms_id(surface, variant) } else { spectrum_id(surface, variant) }
}

/// Identity of a term table: everything that its numbers and its size come from.
fn terms_id(surface: &Loaded, variant: &Variant) -> String {
    let terms = match variant.terms {
        Auto::Value(terms) => json!(terms),
        Auto::Auto => json!({ "error": variant.term_error }),
    };
    let radius = match (variant.mode, variant.window_radius) {
        (Mode::Adaptive, _) => {
            let optics = &variant.optics;
            json!(["adaptive", optics.coherence_um, optics.coherence_scaling])
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
    let rotate_deg = surface.spec.rotate_deg;
    let Wavelengths { min_nm, max_nm, .. } = variant.wavelengths;
    let mut inputs = match variant.mode {
        Mode::Full | Mode::Pq => json!([TOOL_VERSION, illuminant, variant.wavelengths, rotate_deg]),
        Mode::Adaptive => {
            json!([TOOL_VERSION, "adaptive", illuminant, min_nm, max_nm, rotate_deg])
        }
        Mode::Gems => json!([TOOL_VERSION, "gems", surface.hash]),
    };
    if variant.table == TableFormat::F16 {
        // the scales of the terms are in it
        inputs = json!([inputs, terms_id(surface, variant)]);
    }
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
