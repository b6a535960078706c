//! The files of one variant on one surface.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::PoisonError;

use serde_json::{Value, json};

use crate::diagnostic::Diagnostic;
use crate::encode::json as json_file;
use crate::error::Error;
use crate::hash::{TOOL_VERSION, of_value};
use crate::package::manifest::{Described, TableEntry, describe, manifest};
use crate::package::probe::Probed;
use crate::package::{Content, Equality, Gap, JSON_TOLERANCE, Package, bindings, probe};
use crate::plan::{Mode, TableFormat, Variant};
use crate::shader::emit::emit;
use crate::shader::specialise;
use crate::tables::container::encode;
use crate::tables::{TERMS, Table, TableSpec, TexelFormat};
use crate::variant::{
    Form, Function, FunctionKind, MAX_PROBE_ERROR, Twin, is_whole_light, probe_error, probes_of,
};

use super::identity;
use super::work::{Loaded, Work};

/// A variant on a surface: its texts, and what its tables are to be.
pub(super) struct Built<'a> {
    pub(super) surface: &'a Loaded<'a>,
    pub(super) variant: &'a Variant,
    form: &'a Form,
    tables: Vec<TableSpec>,
    /// Names of the tables.
    pub(super) ids: Vec<String>,
    /// Everything but the tables and the probes.
    files: Vec<(String, Vec<u8>, Equality)>,
}

/// Specialises, validates and emits the texts of a variant on a surface.
pub(super) fn build<'a>(
    work: &Work<'_>,
    surface: &'a Loaded<'a>,
    variant: &'a Variant,
    form: &'a Form,
) -> Result<Built<'a>, Vec<Diagnostic>> {
    let (name, rotate_deg) = (surface.name(), surface.rotate_deg());
    let label = format!("{name} {}", variant.name);
    let one = |error: Error| vec![Diagnostic::from(&error).variant(&label)];
    let tables = form.tables(surface.ground());
    let ids: Vec<String> = tables.iter().map(TableSpec::id).collect();
    let shapes: Vec<Table> = tables.iter().map(TableSpec::shape).collect();
    let defines = specialise::defines(variant, form, rotate_deg, specialise::node_count(&shapes));
    let module = specialise::shader(work.sources, &label, form, &defines)?;
    let mut emitted = Vec::new();
    for &target in work.targets {
        emitted.extend(emit(&module, target).map_err(one)?);
    }
    let entry = |(table, id): (&Table, &String)| TableEntry {
        binding: table.name,
        id: id.clone(),
        description: format!("../../../surfaces/{name}/{id}.json"),
        data: format!("../../../surfaces/{name}/{id}.bin"),
    };
    let entries = shapes.iter().zip(&ids).map(|pair| (pair.0, entry(pair))).collect();
    let mut inputs =
        vec![json!(surface.input.identity()), json!(variant.hash()), json!(TOOL_VERSION)];
    inputs.extend(variant.optics.matter());
    let input_hash = of_value(&Value::Array(inputs));
    let energy = surface.energy(&variant.optics);
    let subject = Described { surface: name, variant, form, tables: entries, input_hash, energy };
    let manifest = manifest(subject, &module, &emitted);
    let folder = format!("shaders/{name}/{}", variant.name);
    let rust = bindings::rust(&manifest, &shapes.iter().collect::<Vec<_>>()).map_err(one)?;
    let manifest_path = format!("{folder}/manifest.json");
    let text = json_file(&manifest_path, &manifest).map_err(one)?;
    let mut files = vec![
        (manifest_path, text.into(), Equality::Json { tolerance: JSON_TOLERANCE }),
        (format!("{folder}/{}", bindings::FILE), rust.into(), Equality::Bytes),
    ];
    // two targets may share a file, as those of GLSL share the function form
    let pathed = emitted.into_iter().map(|file| (format!("{folder}/{}", file.name), file));
    let fresh = pathed.filter(|(path, file)| !(work.keep)(path, file.target));
    let fresh: BTreeMap<String, Vec<u8>> = fresh.map(|(path, file)| (path, file.bytes)).collect();
    files.extend(fresh.into_iter().map(|(path, bytes)| (path, bytes, Equality::Bytes)));
    Ok(Built { surface, variant, form, tables, ids, files })
}

/// The term table that was read last, with its path: variants that share one come together.
pub(super) type Last = Option<(String, Table)>;

impl Built<'_> {
    /// Adds all files, or returns why the variant is left out. `baked` is called with the columns of a table of colours that were finished, and how many it has.
    pub(super) fn insert(
        mut self,
        work: &Work<'_>,
        package: &mut Package,
        last: &mut Last,
        baked: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Option<Gap>, Error> {
        let known: BTreeSet<String> = package.files().keys().cloned().collect();
        for (spec, id) in self.tables.iter().zip(&self.ids) {
            (work.go_on)()?;
            if !package.files().contains_key(&self.table_path(id)) {
                // a new table is not the one in memory, which only takes space from now on
                *last = None;
            }
            self.insert_table(spec, id, work, package, baked)?;
        }
        let (surface, variant) = (self.surface.name(), &self.variant.name);
        let probed: Vec<Probed> = self
            .form
            .functions()
            .into_iter()
            .map(|function| self.probes(function, work, package, last))
            .collect::<Result<_, _>>()?;
        if let (Some(reason), false) = (self.refusal(&probed)?, self.variant.accept_error) {
            // the tables that came with it
            package.retain(|path| known.contains(path));
            let reason = Error::new(variant, reason).remedy(remedy(self.variant.mode)).to_string();
            return Ok(Some(Gap { surface: surface.to_owned(), variant: variant.clone(), reason }));
        }
        for (path, bytes, compare) in std::mem::take(&mut self.files) {
            package.insert(&path, bytes, compare)?;
        }
        let path = format!("shaders/{surface}/{variant}/probe.json");
        let probes = probe::json(surface, self.variant, self.form, &probed)?;
        package.insert(&path, probes, Equality::Json { tolerance: probe::TOLERANCE })?;
        Ok(None)
    }

    /// Why the probes show that the variant is not what it claims to be. `None` if they agree, or if the variant has only
    /// a part of the light of the exact colours.
    fn refusal(&self, probed: &[Probed]) -> Result<Option<String>, Error> {
        if !is_whole_light(self.variant)? {
            return Ok(None);
        }
        let error = |of: &Probed| {
            let error = probe_error(self.form, &of.exact_xyz(), &of.expected)?;
            // a number that is not finite is no agreement either
            let agrees = error <= MAX_PROBE_ERROR;
            (!agrees).then(|| {
                format!(
                    "its colours have little to do with the exact ones: on the {} probes of {} they differ by {error:.2} \
                     of these (root mean square), above {MAX_PROBE_ERROR}",
                    of.expected.len(),
                    of.function.name()
                )
            })
        };
        // one path is not the mean of all
        let means = probed.iter().filter(|of| of.function.kind() != FunctionKind::Path);
        Ok(means.into_iter().find_map(error))
    }

    fn insert_table(
        &self,
        spec: &TableSpec,
        id: &str,
        work: &Work<'_>,
        package: &mut Package,
        baked: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<(), Error> {
        let path = self.table_path(id);
        // the variants of a surface share a table, made once
        if package.files().contains_key(&path) {
            return Ok(());
        }
        let table = spec.shape();
        let done = |columns: usize| baked(columns, spec.columns());
        let make = || spec.bytes_with(self.surface.field, &done);
        let content = if spec.is_expensive() {
            work.cache.content(id, table.byte_count(), make)?
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
        for &container in work.containers {
            let file = encode(container, &shape, &content.read()?)?;
            let compare = Equality::Container { container, shape, tolerance };
            let beside = path.replace(".bin", &format!(".{}", container.as_str()));
            package.insert(&beside, file, compare)?;
        }
        let compare = Equality::Table { format, tolerance, layer: shape.layer_numbers() };
        package.insert_content(&path, content, compare)?;
        let description = path.replace(".bin", ".json");
        let about = json_file(&description, &describe(spec, id, work.containers))?;
        package.insert(&description, about, Equality::Json { tolerance: JSON_TOLERANCE })
    }

    fn table_path(&self, id: &str) -> String {
        format!("surfaces/{}/{id}.bin", self.surface.name())
    }

    /// The probes of a function with their exact colours, and the colours of the variant's algorithm on its packed tables.
    fn probes(
        &self,
        function: &'static dyn Function,
        work: &Work<'_>,
        package: &Package,
        last: &mut Last,
    ) -> Result<Probed, Error> {
        let Built { surface, variant, form, .. } = self;
        let cache = work.cache;
        let rotate_deg = surface.rotate_deg();
        let id = identity::exact_id(function, surface.input.identity(), variant);
        let mut known = surface.exact.lock().unwrap_or_else(PoisonError::into_inner);
        let exact = match known.get(&id) {
            Some(exact) => exact.clone(),
            None => {
                let count = probe::width(function) * function.probe_count();
                let numbers = cache.numbers(&id, count, || {
                    let exact = probes_of(function, variant, surface.field, rotate_deg)?;
                    Ok(probe::to_numbers(&exact))
                })?;
                let exact = probe::from_numbers(function, variant, &numbers);
                known.insert(id, exact.clone());
                exact
            }
        };
        drop(known);
        let id = identity::expected_id(function, surface.input.identity(), variant);
        let expected = cache.numbers(&id, 3 * function.probe_count(), || {
            let mut tables = Vec::new();
            for (spec, id) in self.tables.iter().zip(&self.ids) {
                let (path, shape) = (self.table_path(id), spec.shape());
                match package.files().get(&path).filter(|_| spec.is_expensive()) {
                    // variants of a surface share the largest table
                    Some(_) if shape.binding == TERMS => {
                        self.read_terms(spec, &path, package, last)?;
                    }
                    Some(file) => tables.push(file.content.table(shape)?),
                    None => tables.push(spec.compute(surface.field)?.rounded()),
                }
            }
            let is_shared = |spec: &TableSpec| spec.is_expensive() && spec.shape().binding == TERMS;
            let mut twin = Twin::new(form, &tables, rotate_deg);
            if let (Some((_, terms)), true) = (last.as_ref(), self.tables.iter().any(is_shared)) {
                twin.terms = terms;
            }
            Ok(probe::expected(&twin, &exact).concat())
        })?;
        let (expected, _) = expected.as_chunks();
        Ok(Probed { function, exact, expected: expected.to_vec() })
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
            *last = Some((path.to_owned(), file.content.table(spec.shape())?));
        }
        Ok(())
    }
}

/// Remedy of a variant whose probes disagree with the truth.
fn remedy(mode: Mode) -> &'static str {
    match mode {
        Mode::Baked => "use a larger bake_mib or a smaller bake_error",
        _ => {
            "use a smaller step_nm, a larger window_radius, table = \"f32\" or more terms; accept_error = true builds it all \
             the same"
        }
    }
}

/// Largest difference between processors of a number in a table, relative to the layer's largest: the rounding to 32
/// bits, once more.
const TABLE_TOLERANCE: f64 = 2.4e-7;
/// The same of a table of 16-bit floats.
const HALF_TOLERANCE: f64 = 1e-3;
/// The same of nine bits with a common exponent.
const SHARED_TOLERANCE: f64 = 4e-3;
