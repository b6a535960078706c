//! The keys of a plan that a material of a glTF file gives.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::optics::Matter;
use diffraction_shaders::plan::{Data, Film, Material, Medium, Optics};

use super::metal::{self, Table};
use super::read::GltfMaterial;

/// From this `metallicFactor` on a material is a metal.
const METAL: f64 = 0.5;

/// Up to this CIEDE2000 of its colour a metal counts as the named one. Values that renderers use for gold are 4 from the
/// colour of gold here.
pub(super) const NEAR: f64 = 5.0;

/// Refractive index of a clear coat (KHR_materials_clearcoat).
const COAT_INDEX: f64 = 1.5;

/// What lies at the relief.
pub(super) enum Base {
    /// Its refractive index.
    Dielectric(f64),
    Metal {
        /// Its table of n and k.
        table: Table,
        /// The nearest named metal, with its CIEDE2000.
        nearest: (&'static str, f64),
    },
}

/// Keys of a plan's optics.
pub(super) struct Keys {
    pub(super) base: Base,
    /// 1 for none.
    pub(super) cover_index: f64,
    /// Refractive index and thickness in nm.
    pub(super) film: Option<(f64, f64)>,
    /// What is left out or simplified.
    pub(super) notes: Vec<String>,
}

impl Keys {
    /// The keys of a material. It is an error, with `subject`, if a plan cannot have it.
    pub(super) fn new(material: &GltfMaterial, subject: &str) -> Result<Keys> {
        let mut notes = Vec::new();
        let refused = |cause: String| Error::new(subject, cause).remedy(REMEDY);
        let base = base(material, &mut notes, subject)?;
        let cover_index = cover(material, &mut notes).map_err(refused)?;
        let film = film(material, &mut notes).map_err(refused)?;
        others(material, &mut notes);
        let mut keys = Keys { base, cover_index, film, notes };
        if let Err(error) = Matter::new(&keys.optics()) {
            keys.cover_index = 1.0;
            Matter::new(&keys.optics()).map_err(|_| Error::new(subject, error.message()))?;
            keys.notes.push("the coat is left out: its index is that of the body, so nothing is reflected between them. The relief counts as the coat's outer face".to_owned());
        }
        Ok(keys)
    }

    /// The named metal, if its colour is near enough.
    pub(super) fn named(&self) -> Option<&'static str> {
        match self.base {
            Base::Metal { nearest: (name, difference), .. } if difference <= NEAR => Some(name),
            _ => None,
        }
    }

    fn optics(&self) -> Optics {
        let mut optics = Optics::standard();
        optics.cover_index = Medium::Constant(self.cover_index);
        let film = |(n, thickness_nm)| Film { index: Medium::Constant(n), thickness_nm };
        optics.films = self.film.map(film).into_iter().collect();
        match &self.base {
            Base::Dielectric(n) => optics.refractive_index = *n,
            Base::Metal { table, .. } => {
                let csv = metal::csv(&table.rows, "a metal").into_bytes();
                let medium = Medium::File(Data::new("metal.csv").with_content(csv));
                optics.material = Material::Medium(medium);
            }
        }
        optics
    }
}

const REMEDY: &str = "correct the material and export it again";

fn base(material: &GltfMaterial, notes: &mut Vec<String>, subject: &str) -> Result<Base> {
    let GltfMaterial { base_colour, metallic, .. } = material;
    let specular = material.extension("KHR_materials_specular");
    if material.has_metallic_texture {
        notes.push(format!("metallicRoughnessTexture varies the material and is not read: metallicFactor = {metallic} alone decides"));
    } else if *metallic > 0.0 && *metallic < 1.0 {
        let kind = if *metallic >= METAL { "a metal" } else { "a dielectric" };
        notes.push(format!(
            "metallicFactor = {metallic} counts as {kind}: a surface is one of them"
        ));
    }
    if *metallic >= METAL {
        if base_colour.iter().all(|c| *c <= 0.0) {
            return Err(Error::new(
                subject,
                "is a metal whose base colour is black: it reflects nothing",
            )
            .remedy("give the metal its colour, or set metallicFactor to 0"));
        }
        if material.has_colour_texture {
            notes.push("baseColorTexture multiplies the base colour and is not read: set baseColorFactor to the colour of the metal".to_owned());
        }
        if specular.is_present() {
            notes.push("KHR_materials_specular does not act on metals".to_owned());
        }
        let (table, nearest) = (metal::table(*base_colour)?, metal::nearest(*base_colour)?);
        return Ok(Base::Metal { table, nearest });
    }
    let refused = |cause: String, remedy: &str| Err(Error::new(subject, cause).remedy(remedy));
    let ior = material.extension("KHR_materials_ior").number("ior", 1.5);
    let ior = ior.map_err(|cause| Error::new(subject, cause).remedy(REMEDY))?;
    let remedy = "give its ior a value above 1 and at most 5, or leave it out for 1.5";
    if ior == 0.0 {
        return refused("has the ior 0, which stands for a body that reflects all light at every angle (KHR_materials_ior)".to_owned(), remedy);
    }
    if ior == 1.0 {
        return refused("has the ior 1: the body reflects nothing, and results are relative to what it reflects".to_owned(), remedy);
    }
    if !(ior > 1.0 && ior <= 5.0) {
        return refused(
            format!("has the ior {ior}, which is not that of a transparent body"),
            remedy,
        );
    }
    let factor = specular.number("specularFactor", 1.0);
    let factor = factor.map_err(|cause| Error::new(subject, cause).remedy(REMEDY))?;
    if factor != 1.0 || specular.has("specularColorFactor") {
        notes.push(format!("KHR_materials_specular scales the reflectance (specularFactor = {factor}), for which a plan has no key: multiply the radiance of the diffraction by it"));
    }
    Ok(Base::Dielectric(ior))
}

fn cover(material: &GltfMaterial, notes: &mut Vec<String>) -> Result<f64, String> {
    let coat = material.extension("KHR_materials_clearcoat");
    let factor = coat.number("clearcoatFactor", 0.0)?;
    if factor <= 0.0 {
        return Ok(1.0);
    }
    if factor < 1.0 || coat.has("clearcoatTexture") {
        notes.push(format!(
            "clearcoatFactor = {factor}{}: the coat counts as whole",
            textured(coat.has("clearcoatTexture"))
        ));
    }
    Ok(COAT_INDEX)
}

fn film(material: &GltfMaterial, notes: &mut Vec<String>) -> Result<Option<(f64, f64)>, String> {
    let film = material.extension("KHR_materials_iridescence");
    let factor = film.number("iridescenceFactor", 0.0)?;
    let index = film.number("iridescenceIor", 1.3)?;
    let thinnest_nm = film.number("iridescenceThicknessMinimum", 100.0)?;
    let thickness_nm = film.number("iridescenceThicknessMaximum", 400.0)?;
    if factor <= 0.0 || thickness_nm <= 0.0 {
        return Ok(None);
    }
    if !(1.0..=5.0).contains(&index) {
        return Err(format!("has the iridescenceIor {index}, which must be from 1 to 5"));
    }
    if thickness_nm > 10_000.0 {
        return Err(format!("has a film of {thickness_nm} nm, above the limit of 10000 nm"));
    }
    if factor < 1.0 || film.has("iridescenceTexture") {
        notes.push(format!(
            "iridescenceFactor = {factor}{}: the film counts as whole",
            textured(film.has("iridescenceTexture"))
        ));
    }
    if film.has("iridescenceThicknessTexture") {
        notes.push(format!("iridescenceThicknessTexture varies the film from {thinnest_nm} to {thickness_nm} nm and is not read: the maximum counts"));
    }
    Ok(Some((index, thickness_nm)))
}

/// Extensions that give no key.
fn others(material: &GltfMaterial, notes: &mut Vec<String>) {
    if material.extension("KHR_materials_anisotropy").is_present() {
        notes.push("KHR_materials_anisotropy is not taken over: the direction of the grooves is the tangent's, turned by the map of angles that the shader reads".to_owned());
    }
    if material.extension("KHR_materials_pbrSpecularGlossiness").is_present() {
        notes.push("KHR_materials_pbrSpecularGlossiness is not read: convert the material to metallic-roughness".to_owned());
    }
}

fn textured(is_textured: bool) -> &'static str {
    if is_textured { " with a texture, which is not read" } else { "" }
}
