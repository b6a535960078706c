//! From a plan to a package: every variant on every surface, all errors in one run.
//!
//! Tables are shared by the variants of a surface that need the same one; their names are hashes of inputs. Work is
//! spread over the current thread pool; the package is the same for any number of threads.

mod cache;
mod identity;
mod step;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::diagnostic::Diagnostic;
use crate::error::Error;
use crate::hash::of_value;
use crate::input::SurfaceInput;
use crate::package::bindings;
use crate::package::manifest::{Described, SCHEMA_VERSION, TableEntry, describe, manifest};
use crate::package::probe;
use crate::package::{Content, Equality, JSON_TOLERANCE, Package};
use crate::plan::{Container, TableFormat, Target, Variant};
use crate::shader::emit::emit;
use crate::shader::specialise;
use crate::shader::template::Sources;
use crate::surface::{self, HeightField};
use crate::tables::container::encode;
use crate::tables::{Table, TableSpec, TexelFormat};
use crate::variant::{DIRECTIONAL, ExactProbe, Form, Function, Ground, PROBES, Twin};

use cache::Cache;

pub use crate::hash::TOOL_VERSION;
pub use step::Step;

/// Version of naga, as pinned in `Cargo.toml`.
pub const NAGA_VERSION: &str = "30.0.1";

/// What to generate.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// The surfaces, their files read.
    pub surfaces: &'a [SurfaceInput],
    /// The variants; each on every surface that it is for, under the optics of the surface.
    pub variants: &'a [Variant],
    /// Languages.
    pub targets: &'a [Target],
    /// File forms of tables beside the raw texels.
    pub containers: &'a [Container],
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
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
pub struct Gap {
    /// Name of the surface.
    pub surface: String,
    /// Name of the variant.
    pub variant: String,
    /// Why.
    pub reason: String,
}

/// Generates everything, or returns every error. `done` is called with each step.
pub fn generate(
    request: &Request<'_>,
    done: &(dyn Fn(Step<'_>) + Sync),
) -> Result<Generated, Vec<Diagnostic>> {
    let surfaces = load(request)?;
    Cache(request.cache).sweep();
    let mut gaps: Vec<Gap> = Vec::new();
    let mut pairs = Vec::new();
    for surface in &surfaces {
        gaps.extend(surface.gaps.iter().cloned());
        pairs.extend(surface.variants.iter().map(|variant| (surface, variant)));
    }
    if pairs.is_empty() {
        let nothing = "nothing is left to generate";
        let error = match gaps.first() {
            Some(Gap { surface, variant, reason }) => {
                let subject = format!("{surface} {variant}");
                Error::new(subject, format!("{nothing}: {reason}"))
            }
            None => Error::new("plan", format!("{nothing}: no variant is for a surface"))
                .remedy("see the key surfaces of its presets"),
        };
        return Err(vec![Diagnostic::from(&error)]);
    }
    let built = pairs.into_par_iter().map(|(s, v)| build(request, s, v));
    let mut built = all_or_errors(built.collect())?;
    // so that the variants that share a table come together, and one term table at a time is in memory
    built.sort_by_cached_key(|one| (one.surface.name().to_owned(), one.ids.clone()));
    let mut package = Package::new();
    let mut last = None;
    let mut errors = Vec::new();
    for one in built {
        let label = format!("{} {}", one.surface.name(), one.variant.name);
        let baked = |columns, of| done(Step::Baked { label: &label, columns, of });
        if let Err(error) = one.insert(request, &mut package, &mut last, &baked) {
            errors.push(Diagnostic::from(&error).variant(&label));
        }
        done(Step::Finished(&label));
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let notes = surfaces.iter().flat_map(|s| s.notes.iter().map(|n| format!("{}: {n}", s.name())));
    let left_out = gaps.iter().map(|gap| format!("{}: left out: {}", gap.surface, gap.reason));
    Ok(Generated { package, notes: notes.chain(left_out).collect(), gaps })
}

/// The variants that are for a surface as they are there, and those that cannot be.
fn placed(request: &Request<'_>, input: &SurfaceInput) -> (Vec<Variant>, Vec<Gap>) {
    let (mut variants, mut gaps) = (Vec::new(), Vec::new());
    for variant in request.variants {
        match variant.on(input.spec()) {
            Some(Ok(variant)) => variants.push(variant),
            Some(Err(error)) => gaps.push(gap(input, variant, &error)),
            None => {}
        }
    }
    (variants, gaps)
}

/// Takes those out that have no form on the heights.
fn formed(input: &SurfaceInput, field: &HeightField, variants: &mut Vec<Variant>) -> Vec<Gap> {
    let mut gaps = Vec::new();
    variants.retain(|variant| match Form::new(variant, field) {
        Ok(_) => true,
        Err(error) => {
            gaps.push(gap(input, variant, &error));
            false
        }
    });
    gaps
}

fn gap(input: &SurfaceInput, variant: &Variant, reason: &Error) -> Gap {
    let (surface, variant) = (input.spec().name.clone(), variant.name.clone());
    Gap { surface, variant, reason: reason.to_string() }
}

/// Hash of everything that a package is made from but the program and the templates: surfaces with their files, variants
/// with their illuminants, languages, containers of tables.
pub fn input_hash(request: &Request<'_>) -> String {
    let surface = |input: &SurfaceInput| {
        let variant =
            |v: &Variant| (v.name.clone(), v.hash(), v.optics.illuminant.identity().to_owned());
        let variants: Vec<_> = placed(request, input).0.iter().map(variant).collect();
        (input.spec().name.clone(), input.identity().to_owned(), variants)
    };
    let surfaces: Vec<_> = request.surfaces.iter().map(surface).collect();
    of_value(&json!([TOOL_VERSION, surfaces, names(request), request.targets, request.containers]))
}

/// Names and hashes of all variants under `[optics]`.
fn names(request: &Request<'_>) -> BTreeMap<String, String> {
    request.variants.iter().map(|v| (v.name.clone(), v.hash())).collect()
}

/// The keys of the package's `manifest.json` beside its list of files; the same in any order of the request.
pub fn index(request: &Request<'_>) -> Result<BTreeMap<String, Value>, Error> {
    let (mut surfaces, mut gaps) = (BTreeMap::new(), Vec::new());
    for input in request.surfaces {
        surfaces.insert(input.spec().name.clone(), json!({ "input_hash": input.identity() }));
        let (mut variants, never) = placed(request, input);
        gaps.extend(never);
        gaps.extend(formed(input, &input.surface()?.field, &mut variants));
    }
    gaps.sort();
    let mut variants = BTreeMap::new();
    for variant in request.variants {
        let mut about = BTreeMap::from([("configuration_hash", json!(variant.hash()))]);
        let here: Vec<_> =
            request.surfaces.iter().map(|i| (i.spec(), variant.on(i.spec()))).collect();
        // where it is not the same everywhere
        if here.iter().any(|(_, on)| !matches!(on, Some(Ok(on)) if on.hash() == variant.hash())) {
            let hashes = here.iter().filter_map(|(spec, on)| match on {
                Some(Ok(on)) => Some((spec.name.clone(), on.hash())),
                _ => None,
            });
            about.insert("surfaces", json!(hashes.collect::<BTreeMap<_, _>>()));
        }
        variants.insert(variant.name.as_str(), json!(about));
    }
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

struct Loaded<'a> {
    input: &'a SurfaceInput,
    field: &'a HeightField,
    notes: &'a [String],
    /// As they are on this surface.
    variants: Vec<Variant>,
    gaps: Vec<Gap>,
    /// Probes with their exact colours by their identity, one for every set of optics.
    exact: Mutex<BTreeMap<String, Vec<ExactProbe>>>,
}

impl Loaded<'_> {
    fn name(&self) -> &str {
        &self.input.spec().name
    }

    fn rotate_deg(&self) -> f64 {
        self.input.spec().rotate_deg
    }

    fn ground(&self) -> Ground<'_> {
        Ground { surface: self.input.identity(), rotate_deg: self.rotate_deg() }
    }
}

struct Built<'a> {
    surface: &'a Loaded<'a>,
    variant: &'a Variant,
    form: Form,
    tables: Vec<TableSpec>,
    /// Names of the tables.
    ids: Vec<String>,
    /// Everything but the tables and the probes.
    files: Vec<(String, Vec<u8>, Equality)>,
}

fn load<'a>(request: &Request<'a>) -> Result<Vec<Loaded<'a>>, Vec<Diagnostic>> {
    let load = |input: &'a SurfaceInput| -> Result<Loaded<'a>, Vec<Diagnostic>> {
        let surface = input.surface().map_err(|e| vec![Diagnostic::from(&e)])?;
        let subject = surface::subject(input.spec());
        let mut errors = BTreeMap::new();
        let (mut variants, mut gaps) = placed(request, input);
        for variant in &variants {
            if let Err(error) = surface.field.check_pitch(&subject, variant.wavelengths.min_nm) {
                errors.insert(error.to_string(), Diagnostic::from(&error).variant(&variant.name));
            }
        }
        if !errors.is_empty() {
            return Err(errors.into_values().collect());
        }
        let (field, notes) = (&surface.field, surface.notes.as_slice());
        gaps.extend(formed(input, field, &mut variants));
        Ok(Loaded { input, field, notes, variants, gaps, exact: Mutex::default() })
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
    surface: &'a Loaded<'a>,
    variant: &'a Variant,
) -> Result<Built<'a>, Vec<Diagnostic>> {
    let (name, rotate_deg) = (surface.name(), surface.rotate_deg());
    let label = format!("{name} {}", variant.name);
    let one = |error: Error| vec![Diagnostic::from(&error).variant(&label)];
    let form = Form::new(variant, surface.field).map_err(one)?;
    let tables = form.tables(surface.ground());
    let ids: Vec<String> = tables.iter().map(TableSpec::id).collect();
    let shapes: Vec<Table> = tables.iter().map(TableSpec::shape).collect();
    let defines = specialise::defines(variant, &form, rotate_deg, specialise::node_count(&shapes));
    let module = specialise::shader(request.sources, &label, &form, &defines)?;
    let mut emitted = Vec::new();
    for &target in request.targets {
        emitted.extend(emit(&module, target).map_err(one)?);
    }
    let entry = |(table, id): (&Table, &String)| TableEntry {
        binding: table.name,
        id: id.clone(),
        description: format!("../../../surfaces/{name}/{id}.json"),
        data: format!("../../../surfaces/{name}/{id}.bin"),
    };
    let entries = shapes.iter().zip(&ids).map(|pair| (pair.0, entry(pair))).collect();
    let input_hash = of_value(&json!([surface.input.identity(), variant.hash(), TOOL_VERSION]));
    let subject = Described { surface: name, variant, form: &form, tables: entries, input_hash };
    let manifest = manifest(subject, &module, &emitted);
    let folder = format!("shaders/{name}/{}", variant.name);
    let rust = bindings::rust(&manifest, &shapes.iter().collect::<Vec<_>>()).map_err(one)?;
    let manifest_path = format!("{folder}/manifest.json");
    let text = pretty(&manifest_path, &manifest).map_err(one)?;
    let mut files = vec![
        (manifest_path, text.into(), Equality::Json { tolerance: JSON_TOLERANCE }),
        (format!("{folder}/{}", bindings::FILE), rust.into(), Equality::Bytes),
    ];
    // two targets may share a file, as those of GLSL share the function form
    let pathed = emitted.into_iter().map(|file| (format!("{folder}/{}", file.name), file));
    let fresh = pathed.filter(|(path, file)| !(request.keep)(path, file.target));
    let fresh: BTreeMap<String, Vec<u8>> = fresh.map(|(path, file)| (path, file.bytes)).collect();
    files.extend(fresh.into_iter().map(|(path, bytes)| (path, bytes, Equality::Bytes)));
    Ok(Built { surface, variant, form, tables, ids, files })
}

/// The term table that was read last, with its path: variants that share one come together.
type Last = Option<(String, Table)>;

impl Built<'_> {
    /// Adds all files. `baked` is called with the columns of a table of colours that were finished, and how many it has.
    fn insert(
        mut self,
        request: &Request<'_>,
        package: &mut Package,
        last: &mut Last,
        baked: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<(), Error> {
        for (path, bytes, compare) in std::mem::take(&mut self.files) {
            package.insert(&path, bytes, compare)?;
        }
        for (spec, id) in self.tables.iter().zip(&self.ids) {
            self.insert_table(spec, id, request, package, baked)?;
        }
        let probes = self.probes(request, package, last)?;
        let path = format!("shaders/{}/{}/probe.json", self.surface.name(), self.variant.name);
        package.insert(&path, probes, Equality::Json { tolerance: probe::TOLERANCE })
    }

    fn insert_table(
        &self,
        spec: &TableSpec,
        id: &str,
        request: &Request<'_>,
        package: &mut Package,
        baked: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<(), Error> {
        let path = self.table_path(id);
        // the variants of a surface share a table, made once
        if package.files().contains_key(&path) {
            return Ok(());
        }
        let table = spec.shape();
        let done = |columns: usize| {
            if let TableSpec::Colours(spec) = spec {
                baked(columns, spec.axes.columns as usize);
            }
        };
        let make = || Ok(spec.compute_with(self.surface.field, &done)?.bytes());
        let content = if spec.is_expensive() {
            Cache(request.cache).content(id, table.byte_count(), make)?
        } else {
            Content::Bytes(make()?)
        };
        let (format, tolerance) = match table.format {
            TexelFormat::Rg32Float | TexelFormat::Rgba32Float => {
                (TableFormat::F32, TABLE_TOLERANCE)
            }
            TexelFormat::Rg16Float | TexelFormat::Rgba16Float => (TableFormat::F16, HALF_TOLERANCE),
            TexelFormat::Rgb9e5Ufloat => (TableFormat::Rgb9e5, SHARED_TOLERANCE),
        };
        let shape = table.shape();
        for &container in request.containers {
            let file = encode(container, &shape, &content.read()?)?;
            let compare = Equality::Container { container, shape, tolerance };
            let beside = path.replace(".bin", &format!(".{}", container.as_str()));
            package.insert(&beside, file, compare)?;
        }
        let compare = Equality::Table { format, tolerance, layer: shape.layer_numbers() };
        package.insert_content(&path, content, compare)?;
        let description = path.replace(".bin", ".json");
        let about = pretty(&description, &describe(spec, id, request.containers))?;
        package.insert(&description, about, Equality::Json { tolerance: JSON_TOLERANCE })
    }

    fn table_path(&self, id: &str) -> String {
        format!("surfaces/{}/{id}.bin", self.surface.name())
    }

    fn probes(
        &self,
        request: &Request<'_>,
        package: &Package,
        last: &mut Last,
    ) -> Result<String, Error> {
        let Built { surface, variant, form, .. } = self;
        let (function, cache) = (&DIRECTIONAL, Cache(request.cache));
        let (optics, rotate_deg) = (&variant.optics, surface.rotate_deg());
        let id = identity::exact_id(function, surface.input.identity(), optics);
        let mut known = surface.exact.lock().unwrap_or_else(PoisonError::into_inner);
        let exact = match known.get(&id) {
            Some(exact) => exact.clone(),
            None => {
                let numbers = cache.numbers(&id, 9 * PROBES, || {
                    let exact = function.probes(surface.field, rotate_deg, optics)?;
                    Ok(probe::to_numbers(&exact))
                })?;
                let exact = probe::from_numbers(&numbers);
                known.insert(id, exact.clone());
                exact
            }
        };
        drop(known);
        let id = identity::expected_id(function, surface.input.identity(), variant);
        let expected = cache.numbers(&id, 3 * PROBES, || {
            let mut tables = Vec::new();
            for (spec, id) in self.tables.iter().zip(&self.ids) {
                if spec.is_expensive() {
                    self.read_terms(spec, &self.table_path(id), package, last)?;
                } else {
                    tables.push(spec.compute(surface.field)?.rounded());
                }
            }
            let mut twin = Twin::new(form, &tables, optics, rotate_deg);
            if let (Some((_, terms)), true) =
                (last.as_ref(), self.tables.iter().any(TableSpec::is_expensive))
            {
                twin.terms = terms;
            }
            Ok(probe::expected(function, &twin, &exact).concat())
        })?;
        let (expected, _) = expected.as_chunks();
        probe::json(surface.name(), &variant.name, optics.colour, form, &exact, expected)
    }

    /// Makes `last` the term table at a path.
    fn read_terms(
        &self,
        spec: &TableSpec,
        path: &str,
        package: &Package,
        last: &mut Last,
    ) -> Result<(), Error> {
        if last.as_ref().is_some_and(|(known, _)| known == path) {
            return Ok(());
        }
        *last = None;
        if let Some(file) = package.files().get(path) {
            let table = spec.shape().with_bytes(&file.content.read()?);
            *last = Some((path.to_owned(), table));
        }
        Ok(())
    }
}

/// Largest difference between processors of a number in a table, relative to the layer's largest: the rounding to 32
/// bits, once more.
const TABLE_TOLERANCE: f64 = 2.4e-7;
/// The same of a table of 16-bit floats.
const HALF_TOLERANCE: f64 = 1e-3;
/// The same of nine bits with a common exponent.
const SHARED_TOLERANCE: f64 = 4e-3;

fn pretty(path: &str, value: &impl serde::Serialize) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|e| Error::new(path, "cannot be written as JSON").source(e))?;
    Ok(text + "\n")
}
