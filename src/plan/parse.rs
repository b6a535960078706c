//! Parses the text of a plan into data. All errors of a text are reported together, each with its line.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use toml::de::DeTable;

use crate::error::{Error, Result};
use crate::hash::sha256;

use super::constraints;
use super::item::{Item, Source, Table};
use super::names::name_of;
use super::target::TARGETS;
use super::variants::{read_optics, read_preset, read_product};
use super::words::{self, Words};
use super::{Container, Optics, Plan, Rejected, SurfaceSpec, Target, Variant, surface};

pub(super) const SECTIONS: [&str; 6] =
    ["schema", "surface", "optics", "variants", "preset", "targets"];

/// Keys of a preset in addition to those of a variant.
pub(super) const PRESET: [&str; 2] = ["name", SURFACES];

/// The key of a preset that lists its surfaces.
const SURFACES: &str = "surfaces";

/// A key of `[targets]` with its words.
pub(super) const EMIT: (&str, Words<Target>) = ("emit", TARGETS);

/// A key of `[targets]` with its words.
pub(super) const TABLES: (&str, Words<Option<Container>>) = ("tables", words::CONTAINERS);

impl Plan {
    /// Checks the text of a plan. `path` is its name in messages; files in the plan are relative to the folder of `path`.
    pub fn parse(text: &str, path: &Path) -> Result<Plan> {
        Plan::parse_all(text, path).map_err(first)
    }

    /// Like [`Plan::parse`], but returns all errors.
    pub fn parse_all(text: &str, path: &Path) -> Result<Plan, Vec<Error>> {
        let hash = sha256(text.as_bytes());
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = Source::new(text, path.display());
        let (document, faults) = DeTable::parse_recoverable(text);
        if !faults.is_empty() {
            source.fail_toml(&faults);
            return Err(source.into_errors());
        }
        let plan = sections(&Table::root(&source, document.get_ref()), folder(path), hash);
        match (plan, source.into_errors()) {
            (Some(plan), errors) if errors.is_empty() => Ok(plan),
            (None, errors) if errors.is_empty() => {
                Err(vec![Error::new(path.display(), "is not a plan").remedy(PLAN)])
            }
            (_, errors) => Err(errors),
        }
    }

    /// Reads the text of one `[[preset]]` as if it were part of this plan, under the plan's `[optics]`.
    pub fn preset(&self, text: &str) -> Result<Variant, Vec<Error>> {
        let source = Source::new(text, "preset");
        let (document, faults) = DeTable::parse_recoverable(text);
        for fault in &faults {
            source.fail(fault.span().map_or(0, |span| span.start), fault.message(), None);
        }
        let read = |root: Table| {
            let mut variants = Vec::new();
            root.only(&["preset"]);
            let names = self.surfaces.iter().map(|s| s.name.as_str()).collect();
            presets(&root, &self.optics, &names, &mut variants, &mut Vec::new());
            variants
        };
        let variants = read(Table::root(&source, document.get_ref()));
        match (<[Variant; 1]>::try_from(variants), source.into_errors()) {
            (Ok([variant]), errors) if errors.is_empty() => Ok(variant),
            (_, errors) if errors.is_empty() => Err(vec![
                Error::new("preset", "the text is not exactly one [[preset]]")
                    .remedy("pass one [[preset]] with a name"),
            ]),
            (_, errors) => Err(errors),
        }
    }
}

/// Remedy of a text that has nothing of a plan.
const PLAN: &str = "a plan needs schema = 1 and at least one [[surface]]";

fn first(errors: Vec<Error>) -> Error {
    errors.into_iter().next().unwrap_or_else(|| Error::new("plan", "is not a plan").remedy(PLAN))
}

fn folder(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).to_owned()
}

fn sections(root: &Table, folder: PathBuf, text_hash: String) -> Option<Plan> {
    if root.items().is_empty() {
        root.source.fail_file("is empty", PLAN);
        return None;
    }
    root.schema("the version of the plan's format; write schema = 1");
    root.only(&SECTIONS);
    let section = |key: &str, what: &str| root.get(key).and_then(|item| item.table(what));
    let optics =
        section("optics", "[optics]").map_or_else(Optics::standard, |table| read_optics(&table));
    let mut notes = Vec::new();
    let mut rejected = Vec::new();
    let mut variants = product(root, &optics, &mut rejected, &mut notes);
    let names = surface_names(root);
    presets(root, &optics, &names, &mut variants, &mut notes);
    let (targets, containers) = targets(section("targets", "[targets]").as_ref());
    let surfaces = surfaces(root, &folder, &variants);
    notes.extend(unused(&surfaces, &variants));
    if let (true, Some(Rejected { name, reason })) = (variants.is_empty(), rejected.first()) {
        let remedy = "change the value of an axis, or add a preset";
        root.source.fail_file(
            format!("every combination of [variants] is rejected; the first is {name}: {reason}"),
            remedy,
        );
    }
    Some(Plan {
        folder,
        text_hash,
        surfaces,
        optics,
        variants,
        rejected,
        targets,
        containers,
        notes,
    })
}

/// Notes about surfaces that no variant is for.
fn unused(surfaces: &[SurfaceSpec], variants: &[Variant]) -> Vec<String> {
    if variants.is_empty() || variants.iter().any(|variant| variant.surfaces.is_none()) {
        return Vec::new();
    }
    let used: BTreeSet<&String> = variants.iter().flat_map(|v| &v.surfaces).flatten().collect();
    let unused = surfaces.iter().filter(|surface| !used.contains(&surface.name));
    unused.map(|surface| format!("{}: no variant is for this surface", surface.name)).collect()
}

fn product(
    root: &Table,
    optics: &Optics,
    rejected: &mut Vec<Rejected>,
    notes: &mut Vec<String>,
) -> Vec<Variant> {
    let base = Variant::standard(optics);
    let combinations = match root.get("variants") {
        Some(item) => {
            item.table("[variants]").map_or_else(Vec::new, |table| read_product(&table, &base))
        }
        None if root.get("preset").is_some() => Vec::new(),
        None => vec![base],
    };
    let mut seen: BTreeMap<String, u32> = BTreeMap::new();
    let mut variants = Vec::new();
    for mut variant in combinations {
        constraints::normalise(&mut variant);
        let name = name_of(&variant);
        let times = seen.entry(name.clone()).or_default();
        *times += 1;
        if *times > 1 {
            continue;
        }
        let reasons: Vec<String> =
            constraints::broken(&variant).into_iter().map(|(_, r)| r).collect();
        if reasons.is_empty() {
            variants.push(Variant { name, ..variant });
        } else {
            rejected.push(Rejected { name, reason: reasons.join("; ") });
        }
    }
    for (name, times) in seen.into_iter().filter(|(_, times)| *times > 1) {
        notes.push(format!(
            "{name}: {times} combinations of [variants] differ only in keys that this mode does not read; one is built"
        ));
    }
    variants
}

/// Two variants with the same identity have the same configuration on every surface. The stated keys are part of it,
/// because a surface's own optics do not override them.
type Identity = (String, Vec<&'static str>, Option<Vec<String>>);

fn presets(
    root: &Table,
    optics: &Optics,
    surfaces: &BTreeSet<&str>,
    variants: &mut Vec<Variant>,
    notes: &mut Vec<String>,
) {
    let base = Variant::standard(optics);
    let own: Vec<Table> = optics_of_surfaces(root);
    let identity = |variant: &Variant| -> Identity {
        let mut stated = variant.stated.clone();
        stated.retain(|key| own.iter().any(|table| table.get(key).is_some()));
        (variant.hash(), stated, variant.surfaces.clone())
    };
    let mut names: BTreeSet<String> = variants.iter().map(|variant| variant.name.clone()).collect();
    // the first variant of each configuration
    let mut known: BTreeMap<Identity, String> = BTreeMap::new();
    if root.get("preset").is_some() {
        for variant in variants.iter() {
            known.entry(identity(variant)).or_insert_with(|| variant.name.clone());
        }
    }
    for table in root.tables("preset") {
        let name = surface::name(&table);
        let path = name.as_ref().map_or(table.path.clone(), |name| format!("preset.{name}"));
        let table = table.renamed(path);
        let only = table.get(SURFACES).map(|item| surfaces_of(&item, surfaces));
        let variant = read_preset(&table, &PRESET, &base);
        let (Some(name), Some(variant)) = (name, variant) else { continue };
        let Some(item) = table.get("name") else { continue };
        let variant = Variant { surfaces: only, ..variant };
        if name == Variant::TEXTS {
            item.fail(
                "is the name of a built-in preset",
                "choose another name; the built-in preset is selected with --variant texts",
            );
        } else if !names.insert(name.clone()) {
            item.fail("is the name of another variant", "choose another name");
        } else {
            match known.entry(identity(&variant)) {
                Entry::Occupied(other) => {
                    notes.push(format!("{name}: has the same configuration as {}", other.get()));
                }
                Entry::Vacant(free) => {
                    free.insert(name.clone());
                }
            }
            variants.push(Variant { name, ..variant });
        }
    }
}

/// The names of a preset's surfaces. Each must be in the plan.
fn surfaces_of(item: &Item, known: &BTreeSet<&str>) -> Vec<String> {
    let mut names = Vec::new();
    let mut seen = BTreeSet::new();
    for item in several(item, "surface") {
        let Some(name) = item.string("the name of a surface") else { continue };
        if !known.contains(name) {
            item.unknown("is not a surface of the plan", known);
        } else if !seen.insert(name) {
            item.fail("is listed twice", "remove one of the two");
        } else {
            names.push(name.to_owned());
        }
    }
    names
}

/// The names of all surfaces, including those with errors.
fn surface_names<'s>(root: &Table<'s, '_>) -> BTreeSet<&'s str> {
    let all = surface_tables(root);
    all.iter().filter_map(|table| table.get("name")?.as_str()).collect()
}

/// The optics of surfaces that have their own.
fn optics_of_surfaces<'s, 't>(root: &Table<'s, 't>) -> Vec<Table<'s, 't>> {
    let own = |table: &Table<'s, 't>| table.get(surface::OPTICS).filter(Item::is_table);
    let items: Vec<Item> = surface_tables(root).iter().filter_map(own).collect();
    items.iter().filter_map(|item| item.table("optics")).collect()
}

/// The tables of `[[surface]]`. Their errors are reported when they are read.
fn surface_tables<'s, 't>(root: &Table<'s, 't>) -> Vec<Table<'s, 't>> {
    let Some(item) = root.get("surface").filter(Item::is_array) else { return Vec::new() };
    let elements = item.elements("tables").unwrap_or_default();
    elements.iter().filter(|item| item.is_table()).filter_map(|item| item.table("")).collect()
}

/// Reads all surfaces, each with the shortest wavelength of its variants.
fn surfaces(root: &Table, folder: &Path, variants: &[Variant]) -> Vec<SurfaceSpec> {
    // by surface; `None` for variants that are for all surfaces
    let mut shortest: BTreeMap<Option<&str>, f64> = BTreeMap::new();
    for variant in variants {
        let names = variant.surfaces.as_deref();
        let places =
            names.map_or_else(|| vec![None], |all| all.iter().map(|n| Some(&**n)).collect());
        for place in places {
            let known = shortest.entry(place).or_insert(f64::INFINITY);
            *known = known.min(variant.wavelengths.min_nm);
        }
    }
    let shortest_nm = |name: &str| {
        let here = [None, Some(name)].into_iter().filter_map(|place| shortest.get(&place).copied());
        here.reduce(f64::min).unwrap_or(380.0)
    };
    let tables = root.tables("surface");
    if tables.is_empty() && root.get("surface").is_none_or(|item| item.is_array()) {
        root.source.fail_file(
            "has no surface",
            "add a [[surface]] with a name and either a grating or a file",
        );
    }
    let mut names: BTreeSet<String> = BTreeSet::new();
    let mut surfaces = Vec::new();
    for table in tables {
        let name = table.get("name").filter(|item| item.as_str().is_some());
        if let Some(item) = name
            && let Some(text) = item.as_str()
            && !names.insert(text.to_owned())
        {
            item.fail("is the name of another surface", "choose another name");
        }
        surfaces.extend(surface::read(&table, folder, &shortest_nm));
    }
    surfaces
}

fn targets(table: Option<&Table>) -> (Vec<Target>, Vec<Container>) {
    let mut containers = BTreeSet::new();
    let Some(table) = table else { return (Target::all(), Vec::new()) };
    table.only(&[EMIT.0, TABLES.0]);
    if let Some(item) = table.get(TABLES.0) {
        containers.extend(listed(&item, "table container", TABLES.1).into_iter().flatten());
    }
    let mut targets = Vec::new();
    match table.get(EMIT.0) {
        Some(item) => {
            for target in listed(&item, "target", EMIT.1) {
                if !targets.contains(&target) {
                    targets.push(target);
                }
            }
        }
        None => targets = Target::all(),
    }
    (targets, containers.into_iter().collect())
}

/// Words of a list.
fn listed<T: Copy>(item: &Item, what: &str, known: Words<T>) -> Vec<T> {
    several(item, what).iter().filter_map(|item| item.word(known)).collect()
}

/// The elements of a list that must not be empty. A single value counts as a list of one.
fn several<'s, 't>(item: &Item<'s, 't>, what: &str) -> Vec<Item<'s, 't>> {
    if !item.is_array() {
        return vec![item.clone()];
    }
    let items = item.elements("words").unwrap_or_default();
    if items.is_empty() {
        item.fail("is empty", format!("list at least one {what}, or remove the key"));
    }
    items
}
