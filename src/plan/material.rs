//! What a surface is made of: its material, a cover above it, thin films between them, and how polarisation enters.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use super::data::Data;
use super::item::{Item, suggest};
use super::number::number;
use super::words::{OBLIQUITIES, word_of};

/// Metals with a table of n and k in the program, by their words in a plan.
pub const METALS: &[&str] = &["aluminium", "silver", "gold", "copper", "nickel", "chromium"];
/// Transparent media.
pub(super) const COVERS: &[&str] = &["polycarbonate", "pmma"];
/// The word for a material of which only `refractive_index` counts.
pub(super) const DIELECTRIC: &str = "dielectric";

/// Refractive index over the wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum Medium {
    /// The same real number at every wavelength.
    Constant(f64),
    /// A medium whose table is part of the program.
    Named(&'static str),
    /// A table of n and k in a file.
    File(Data),
}

/// What a relief is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Schlick's reflectance of `refractive_index`, without dispersion.
    Dielectric,
    /// Fresnel's reflectance of a medium.
    Medium(Medium),
}

/// A layer of constant thickness that follows the relief.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Its refractive index.
    pub index: Medium,
    /// Its thickness, nm.
    pub thickness_nm: f64,
}

/// How the obliquity factor and the reflectance depend on polarisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Obliquity {
    /// Stam's factor: the square of the mean of both polarisations' amplitudes (Stam 1999, eq. 7).
    Stam,
    /// The mean of both polarisations' intensities.
    Unpolarised,
    /// The electric field is parallel to the grooves.
    Te,
    /// The magnetic field is parallel to the grooves.
    Tm,
}

impl Medium {
    /// Its name: a number, a word or a path.
    pub fn name(&self) -> String {
        match self {
            Medium::Constant(n) => n.to_string(),
            Medium::Named(name) => (*name).to_owned(),
            Medium::File(data) => data.name().to_owned(),
        }
    }

    /// Identity of its numbers: the content of a file counts, and not its path.
    pub fn identity(&self) -> Value {
        match self {
            Medium::File(data) => json!({ "nk": data.identity() }),
            other => json!(other),
        }
    }

    /// Its file, if it has one.
    pub(super) fn data_mut(&mut self) -> Option<&mut Data> {
        match self {
            Medium::File(data) => Some(data),
            _ => None,
        }
    }

    /// A part of a name.
    pub(super) fn part(&self) -> String {
        match self {
            Medium::Constant(n) => number(*n),
            Medium::Named(name) => (*name).to_owned(),
            Medium::File(data) => data.part(),
        }
    }
}

impl Serialize for Medium {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Medium::Constant(n) => serializer.serialize_f64(*n),
            Medium::Named(name) => serializer.serialize_str(name),
            Medium::File(data) => {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry(NK, data.name())?;
                map.end()
            }
        }
    }
}

impl Material {
    /// Identity of its numbers.
    pub fn identity(&self) -> Value {
        match self {
            Material::Dielectric => json!(DIELECTRIC),
            Material::Medium(medium) => medium.identity(),
        }
    }

    pub(super) fn part(&self) -> String {
        match self {
            Material::Dielectric => DIELECTRIC.to_owned(),
            Material::Medium(medium) => medium.part(),
        }
    }
}

impl Serialize for Material {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Material::Dielectric => serializer.serialize_str(DIELECTRIC),
            Material::Medium(medium) => medium.serialize(serializer),
        }
    }
}

impl Film {
    /// Identity of its numbers.
    pub fn identity(&self) -> Value {
        json!([self.index.identity(), self.thickness_nm])
    }
}

impl Serialize for Film {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(2))?;
        map.serialize_entry(INDEX, &self.index)?;
        map.serialize_entry(THICKNESS, &self.thickness_nm)?;
        map.end()
    }
}

impl Obliquity {
    /// The word of the plan.
    pub fn as_str(self) -> &'static str {
        word_of(OBLIQUITIES, self)
    }
}

pub(super) const NK: &str = "nk";
const INDEX: &str = "index";
const THICKNESS: &str = "thickness_nm";

/// Keys of a film.
pub(super) const FILM: [&str; 2] = [INDEX, THICKNESS];
/// Paths of tables that name a file of n and k, each with that of the films it belongs to.
pub(super) const TABLES: [[&str; 2]; 12] = [
    ["optics.material", ""],
    ["optics.cover_index", ""],
    ["optics.films.index", "optics.films"],
    ["surface.optics.material", ""],
    ["surface.optics.cover_index", ""],
    ["surface.optics.films.index", "surface.optics.films"],
    ["variants.material", ""],
    ["variants.cover_index", ""],
    ["variants.films.index", "variants.films"],
    ["preset.material", ""],
    ["preset.cover_index", ""],
    ["preset.films.index", "preset.films"],
];

/// Maximum number of films.
const MAX_FILMS: usize = 16;
/// Maximum thickness of a film, nm.
const MAX_THICKNESS_NM: f64 = 10_000.0;

const FILE: &str =
    "a medium from a file is { nk = \"file.csv\" }, with columns wavelength_nm, n and k";

pub(super) fn material(item: &Item) -> Option<Material> {
    if item.is_table() {
        return file(item).map(|data| Material::Medium(Medium::File(data)));
    }
    let text = item.string("a material, or { nk = \"file.csv\" }")?;
    if text == DIELECTRIC {
        return Some(Material::Dielectric);
    }
    let mut known = vec![DIELECTRIC];
    known.extend(METALS);
    match METALS.iter().find(|name| **name == text) {
        Some(name) => Some(Material::Medium(Medium::Named(name))),
        None => {
            item.fail("unknown material", format!("{}; {FILE}", suggest(text, &known)));
            None
        }
    }
}

pub(super) fn cover(item: &Item) -> Option<Medium> {
    let what = "the refractive index of the cover: 1 for none, a number, \"polycarbonate\", \"pmma\", or { nk = \"file.csv\" }";
    medium(item, COVERS, what, "from 1 to 4", |n| (1.0..=4.0).contains(&n))
}

/// Whether an array of films is one value, and not a list of values: its elements are films, or it has none.
pub(super) fn is_films(item: &Item) -> bool {
    item.elements("films").is_some_and(|items| items.iter().all(Item::is_table))
}

pub(super) fn films(item: &Item) -> Option<Vec<Film>> {
    let items = item.elements("films, from the outside in: { index, thickness_nm }")?;
    if items.len() > MAX_FILMS {
        item.fail(format!("has more than {MAX_FILMS} films"), "leave out films");
        return None;
    }
    let films: Vec<Option<Film>> = items.iter().map(film).collect();
    films.into_iter().collect()
}

fn film(item: &Item) -> Option<Film> {
    let table = item.table("{ index = 1.38, thickness_nm = 120 }")?;
    table.only(&FILM);
    let what = "the refractive index of the film: a number, the name of a medium, or { nk = \"file.csv\" }";
    let known: Vec<&'static str> = METALS.iter().chain(COVERS).copied().collect();
    let index = table.require(INDEX, what).and_then(|index| {
        medium(&index, &known, what, "from 1 to 5", |n| (1.0..=5.0).contains(&n))
    });
    let thick = "the thickness of the film in nm; a thicker layer is a cover";
    let thickness_nm = table.require(THICKNESS, thick).and_then(|item| {
        let must = format!("above 0 and at most {MAX_THICKNESS_NM}");
        item.number(&must, thick, |x| x > 0.0 && x <= MAX_THICKNESS_NM)
    });
    Some(Film { index: index?, thickness_nm: thickness_nm? })
}

/// A number, one of the known names, or a file.
fn medium(
    item: &Item,
    known: &[&'static str],
    what: &str,
    must: &str,
    check: impl Fn(f64) -> bool,
) -> Option<Medium> {
    if item.is_table() {
        return file(item).map(Medium::File);
    }
    let Some(text) = item.as_str() else {
        return item.number(must, what, check).map(Medium::Constant);
    };
    match known.iter().find(|name| **name == text) {
        Some(name) => Some(Medium::Named(name)),
        None => {
            item.fail("unknown medium", format!("{}; {FILE}", suggest(text, known)));
            None
        }
    }
}

fn file(item: &Item) -> Option<Data> {
    let table = item.table(FILE)?;
    table.only(&[NK]);
    let item = table.require(NK, FILE)?;
    let text = item.string("the path of a CSV file with columns wavelength_nm, n and k")?;
    if text.is_empty() || text.chars().any(char::is_control) {
        item.fail("is not the name of a file", FILE);
        return None;
    }
    Some(Data::new(text))
}
