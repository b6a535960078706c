//! Reads the materials of a glTF file.

use std::path::Path;

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::input::read_file;
use serde_json::{Map, Value};

/// Maximum size of a file, in bytes.
const MAX_BYTES: u64 = 512 << 20;

/// What counts of a material of a glTF file.
pub(super) struct GltfMaterial {
    /// Its place in the file, from 0.
    pub(super) index: usize,
    pub(super) name: Option<String>,
    /// Red, green, blue, linear sRGB.
    pub(super) base_colour: [f64; 3],
    pub(super) metallic: f64,
    /// Whether pictures vary the base colour and the metallic factor.
    pub(super) has_colour_texture: bool,
    pub(super) has_metallic_texture: bool,
    extensions: Map<String, Value>,
}

/// An extension of a material. One that is absent has the defaults of all its keys.
pub(super) struct Extension<'a> {
    name: &'static str,
    object: Option<&'a Value>,
}

/// All materials of a file. No other file is opened: buffers and pictures do not count.
pub(super) fn read(path: &Path) -> Result<Vec<GltfMaterial>> {
    let subject = path.display().to_string();
    let bytes = read_file(path, MAX_BYTES).map_err(|error| {
        Error::new(&subject, "cannot be read")
            .source(error)
            .remedy("check the path; a glTF file is a regular file of at most 512 MiB")
    })?;
    // without validation, which refuses extensions of meshes and pictures; no index into another list is followed
    let file = gltf::Gltf::from_slice_without_validation(&bytes).map_err(|error| {
        Error::new(&subject, "is not a glTF 2.0 file")
            .source(error)
            .remedy("name a .gltf or .glb file that a modelling program exported")
    })?;
    let materials = file.document.into_json().materials;
    if materials.is_empty() {
        let remedy = "export it with its materials";
        return Err(Error::new(subject, "has no materials").remedy(remedy));
    }
    let material = |(index, material): (usize, gltf::json::Material)| {
        let pbr = material.pbr_metallic_roughness;
        let [r, g, b, _] = pbr.base_color_factor.0;
        GltfMaterial {
            index,
            name: material.name,
            base_colour: [r, g, b].map(decimal),
            metallic: decimal(pbr.metallic_factor.0),
            has_colour_texture: pbr.base_color_texture.is_some(),
            has_metallic_texture: pbr.metallic_roughness_texture.is_some(),
            extensions: material.extensions.map(|all| all.others).unwrap_or_default(),
        }
    };
    Ok(materials.into_iter().enumerate().map(material).collect())
}

/// The number with the digits that the file has.
fn decimal(number: f32) -> f64 {
    number.to_string().parse().unwrap_or_else(|_| number.into())
}

impl GltfMaterial {
    /// Its name in messages, with control characters written out.
    pub(super) fn label(&self) -> String {
        match &self.name {
            Some(name) => format!("{name:?}"),
            None => format!("material {}", self.index),
        }
    }

    pub(super) fn extension(&self, name: &'static str) -> Extension<'_> {
        Extension { name, object: self.extensions.get(name) }
    }
}

impl Extension<'_> {
    pub(super) fn is_present(&self) -> bool {
        self.object.is_some()
    }

    /// Whether it has a key, such as a texture.
    pub(super) fn has(&self, key: &str) -> bool {
        self.object.is_some_and(|object| object.get(key).is_some())
    }

    /// A number. It is an error, without its subject, if the key holds something else.
    pub(super) fn number(&self, key: &str, default: f64) -> Result<f64, String> {
        let Some(value) = self.object.and_then(|object| object.get(key)) else {
            return Ok(default);
        };
        value.as_f64().ok_or_else(|| format!("{}: {key} is not a number", self.name))
    }
}
