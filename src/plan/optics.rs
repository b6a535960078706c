//! Light and material: the keys of `[optics]`, which are also axes of the product. This file has their names, how they
//! are read, and what they add to a variant's name and configuration.

use std::f64::consts::{PI, SQRT_2};

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::hash::sha256;

use super::axis::{Axis, Part, entry, valued, worded};
use super::data::Data;
use super::item::Item;
use super::material::{self, Film, Material, Medium, Obliquity};
use super::number::number;
use super::words;

/// Light and material.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Optics {
    /// Coherence length ℓc, µm. The window's standard deviation is `ℓc/4`.
    pub coherence_um: f64,
    /// How the orders add.
    pub coherence: Coherence,
    /// How the coherence length depends on the wavelength.
    pub coherence_scaling: CoherenceScaling,
    /// What the relief is made of.
    pub material: Material,
    /// Refractive index `n` of a dielectric.
    pub refractive_index: f64,
    /// Plane-parallel medium above the relief; 1 for none.
    pub cover_index: Medium,
    /// Films on the relief, from the outside in.
    pub films: Vec<Film>,
    /// How polarisation enters.
    pub obliquity: Obliquity,
    /// V-cavity shadowing and masking.
    pub shadowing: bool,
    /// The light's spectrum.
    pub illuminant: Illuminant,
    /// Colour conversion.
    pub colour: Colour,
}

/// How the orders add.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Coherence {
    /// One coherence patch, centred on the surface: the amplitudes of orders add.
    Single,
    /// Mean over all positions of the coherence window: the intensities of orders add.
    Ensemble,
}

/// How the coherence length depends on the wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CoherenceScaling {
    /// One length for all wavelengths.
    Fixed,
    /// Proportional to the wavelength, with the stated length at 550 nm: a source of fixed angular size.
    Wavelength,
}

/// Conversion from tristimulus values to RGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Colour {
    /// Linear sRGB, IEC 61966-2-1.
    Srgb,
    /// The matrices of the thesis texts, for comparison only.
    Thesis,
}

impl Optics {
    /// Keys that a dielectric in air does not need.
    pub const MATTER: [&str; 4] = ["material", "cover_index", "films", "obliquity"];

    /// The defaults of a plan.
    pub fn standard() -> Optics {
        Optics {
            coherence_um: 65.0,
            coherence: Coherence::Single,
            coherence_scaling: CoherenceScaling::Fixed,
            material: Material::Dielectric,
            refractive_index: 1.5,
            cover_index: Medium::Constant(1.0),
            films: Vec::new(),
            obliquity: Obliquity::Stam,
            shadowing: true,
            illuminant: "D65".into(),
            colour: Colour::Srgb,
        }
    }

    /// Everything that exact tristimulus values depend on: all keys except the conversion to RGB.
    pub fn identity(&self) -> Value {
        let Window { coherence_um, coherence, coherence_scaling } = Window::from(self);
        let mut parts = vec![json!(coherence_um), json!(coherence), json!(coherence_scaling)];
        parts.extend(self.without_window());
        Value::Array(parts)
    }

    /// Everything but the window and the conversion to RGB.
    pub fn without_window(&self) -> Vec<Value> {
        let mut parts = vec![
            json!(self.refractive_index),
            json!(self.shadowing),
            json!(self.illuminant.identity()),
        ];
        parts.extend(self.matter());
        parts
    }

    /// The media of the surface, each with its key.
    pub fn media(&self) -> Vec<(&'static str, &Medium)> {
        let material = match &self.material {
            Material::Dielectric => None,
            Material::Medium(medium) => Some(("material", medium)),
        };
        let films = self.films.iter().map(|film| ("films", &film.index));
        [("cover_index", &self.cover_index)].into_iter().chain(material).chain(films).collect()
    }

    /// The tables of n and k that are files.
    pub(crate) fn media_mut(&mut self) -> impl Iterator<Item = &mut Data> {
        let material = match &mut self.material {
            Material::Dielectric => None,
            Material::Medium(medium) => Some(medium),
        };
        let films = self.films.iter_mut().map(|film| &mut film.index);
        films.chain([&mut self.cover_index]).chain(material).filter_map(Medium::data_mut)
    }

    /// Whether the surface is a dielectric in air with Stam's obliquity.
    pub fn is_plain(&self) -> bool {
        let Optics { material, cover_index, films, obliquity, .. } = self;
        *material == Material::Dielectric
            && *cover_index == Medium::Constant(1.0)
            && films.is_empty()
            && *obliquity == Obliquity::Stam
    }

    /// Everything that reflectance depends on. `None` for a dielectric in air with Stam's obliquity.
    pub fn matter(&self) -> Option<Value> {
        let Optics { material, refractive_index, cover_index, films, obliquity, .. } = self;
        let films: Vec<Value> = films.iter().map(Film::identity).collect();
        let material = match material {
            Material::Dielectric => json!([refractive_index]),
            Material::Medium(medium) => medium.identity(),
        };
        (!self.is_plain()).then(|| json!([material, cover_index.identity(), films, obliquity]))
    }
}

/// The Gaussian coherence window.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Window {
    /// Coherence length ℓc, µm; the window's standard deviation is `ℓc/4`.
    pub coherence_um: f64,
    /// How the orders add.
    pub coherence: Coherence,
    /// How the coherence length depends on the wavelength.
    pub coherence_scaling: CoherenceScaling,
}

impl From<&Optics> for Window {
    fn from(optics: &Optics) -> Window {
        let &Optics { coherence_um, coherence, coherence_scaling, .. } = optics;
        Window { coherence_um, coherence, coherence_scaling }
    }
}

/// The spectrum of a light: a CIE name, or the path of a file.
pub type Illuminant = Data;

/// Keys of `[optics]`. As axes of the product they vary fastest.
pub(super) static OPTICS: [Axis; 12] = [
    valued!(
        "coherence_um",
        optics.coherence_um,
        coherence_um,
        "0.1 to 10000",
        "coherence length, µm",
        Part::Changed(|v| format!("lc{}", number(v.optics.coherence_um)))
    ),
    worded!(
        "coherence",
        optics.coherence,
        words::COHERENCES,
        "`single`: the amplitudes of orders add; `ensemble`: their intensities add",
        Part::Changed(|_| "ensemble".to_owned())
    ),
    worded!(
        "coherence_scaling",
        optics.coherence_scaling,
        words::SCALINGS,
        "coherence length: fixed, or proportional to the wavelength (stated at 550 nm)",
        Part::Changed(|_| "lcwave".to_owned())
    ),
    Axis {
        key: "source_diameter_deg",
        about: "angular diameter of a round source, instead of `coherence_um` (56.7 µm divided by it) and `coherence_scaling = \"wavelength\"`; the sun has 0.53",
        values: "0.006 to 180",
        words: Vec::new,
        is_one: None,
        read: |item, into| {
            into.optics.coherence_um = source_coherence_um(item)?;
            into.optics.coherence_scaling = CoherenceScaling::Wavelength;
            Some(())
        },
        entries: &[
            entry!("coherence_um", optics.coherence_um),
            entry!("coherence_scaling", optics.coherence_scaling),
        ],
        part: Part::Alias,
    },
    Axis {
        words: || [&[material::DIELECTRIC], material::METALS].concat(),
        ..valued!(
            "material",
            optics.material,
            material::material,
            "`{ nk = \"file.csv\" }`",
            "what the relief is made of; `dielectric`: only `refractive_index` counts",
            Part::Changed(|v| v.optics.material.part())
        )
    },
    valued!(
        "refractive_index",
        optics.refractive_index,
        refractive_index,
        "above 1, at most 5",
        "refractive index of a dielectric",
        Part::Changed(|v| format!("n{}", number(v.optics.refractive_index)))
    ),
    Axis {
        words: || material::COVERS.to_vec(),
        ..valued!(
            "cover_index",
            optics.cover_index,
            material::cover,
            "1 to 4, `{ nk = \"file.csv\" }`",
            "refractive index of a plane-parallel cover on the relief; 1 for none",
            Part::Changed(|v| format!("under-{}", v.optics.cover_index.part()))
        )
    },
    Axis {
        is_one: Some(material::is_films),
        ..valued!(
            "films",
            optics.films,
            material::films,
            "an array of `{ index, thickness_nm }`",
            "thin films that follow the relief, from the outside in",
            Part::Changed(|v| format!("films-{}", hash_part(&v.optics.films)))
        )
    },
    worded!(
        "obliquity",
        optics.obliquity,
        words::OBLIQUITIES,
        "`stam`: mean of both polarisations' amplitudes; `unpolarised`: of their intensities; `te`, `tm`: one of them",
        Part::Changed(|v| v.optics.obliquity.as_str().to_owned())
    ),
    valued!(
        "shadowing",
        optics.shadowing,
        Item::boolean,
        "`true`, `false`",
        "V-cavity shadowing and masking",
        Part::Changed(|_| "noshadow".to_owned())
    ),
    valued!(
        "illuminant",
        optics.illuminant,
        illuminant,
        "a CIE name, or a CSV file",
        "spectrum of the light",
        Part::Changed(|v| format!("ill-{}", v.optics.illuminant.part()))
    ),
    worded!(
        "colour",
        optics.colour,
        words::COLOURS,
        "conversion to RGB; `thesis` only for comparison with the texts",
        Part::Changed(|_| "thesis".to_owned())
    ),
];

/// Eight digits of the hash of films.
fn hash_part(films: &[Film]) -> String {
    let text = json!(films).to_string();
    sha256(text.as_bytes())[..8].to_owned()
}

fn coherence_um(item: &Item) -> Option<f64> {
    let what = "the coherence length in µm; sunlight has about 65";
    item.number("from 0.1 to 10000", what, |x| (0.1..=10000.0).contains(&x))
}

/// The coherence length in µm at 550 nm, to a nm, whose window has the variance of a disc of that diameter:
/// `(2√2/π) λ0/a` with the angular radius `a` in radians.
fn source_coherence_um(item: &Item) -> Option<f64> {
    let what = "the angular diameter of the source in degrees; the sun has 0.53";
    let diameter_deg = item.number("from 0.006 to 180", what, |x| (0.006..=180.0).contains(&x))?;
    let radius_rad = 0.5 * diameter_deg * PI / 180.0;
    Some((2.0 * SQRT_2 / PI * 0.55 / radius_rad * 1e3).round() / 1e3)
}

fn refractive_index(item: &Item) -> Option<f64> {
    let what = "the refractive index of the material; the gain divides by the reflectance at normal incidence, which is 0 at an index of 1";
    item.number("above 1 and at most 5", what, |n| n > 1.0 && n <= 5.0)
}

fn illuminant(item: &Item) -> Option<Illuminant> {
    let text =
        item.string("the name of an illuminant, such as \"D65\", or the path of a CSV file")?;
    if text.is_empty() || text.chars().any(char::is_control) {
        item.fail(
            "is not the name of an illuminant or a file",
            "use a name such as \"D65\", or the path of a CSV file",
        );
        return None;
    }
    Some(text.into())
}
