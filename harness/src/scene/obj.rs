//! Reads Wavefront OBJ.

use std::path::Path;

use diffraction_shaders::error::{Error, Result};
use glam::{DVec2, DVec3};

use super::raw::Raw;
use crate::drivers::ColourMap;

/// All objects of a file in one mesh. The colour is the first material's texture or plain colour.
pub(super) fn read(path: &Path) -> Result<Raw> {
    let name = path.display().to_string();
    let fail = |error: tobj::LoadError| Error::new(&name, "cannot be read as OBJ").source(error);
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    let (models, materials) = tobj::load_obj(path, &options).map_err(fail)?;
    let mut raw = Raw {
        positions: Vec::new(),
        normals: None,
        tangents: None,
        uvs: None,
        angles: None,
        triangles: Vec::new(),
        colour: ColourMap::plain([128; 3]),
        notes: Vec::new(),
    };
    let (mut normals, mut uvs) = (Vec::new(), Vec::new());
    for mesh in models.iter().map(|model| &model.mesh) {
        let first = raw.positions.len() as u32;
        let count = mesh.positions.len() / 3;
        raw.positions.extend(vectors(&mesh.positions));
        normals.extend(vectors(&mesh.normals));
        normals.resize(raw.positions.len(), DVec3::ZERO);
        uvs.extend(mesh.texcoords.chunks_exact(2).map(|t| {
            // OBJ has v = 0 at the bottom
            DVec2::new(f64::from(t[0]), 1.0 - f64::from(t[1]))
        }));
        uvs.resize(raw.positions.len(), DVec2::NAN);
        debug_assert_eq!(raw.positions.len(), first as usize + count);
        let triangles = mesh.indices.chunks_exact(3);
        raw.triangles.extend(triangles.map(|t| [t[0] + first, t[1] + first, t[2] + first]));
    }
    raw.normals = Some(normals);
    raw.uvs = Some(uvs);
    match materials {
        Ok(materials) => {
            if let Some(material) = materials.first() {
                raw.colour = colour(path, material, &mut raw.notes);
            }
        }
        Err(error) => {
            raw.notes.push(format!("{name}: its materials cannot be read: {error}; using grey"))
        }
    }
    Ok(raw)
}

fn colour(path: &Path, material: &tobj::Material, notes: &mut Vec<String>) -> ColourMap {
    let plain = material.diffuse.unwrap_or([0.5; 3]);
    let code = |c: f32| {
        (255.0 * diffraction_shaders::optics::colour::srgb_encode(f64::from(c))).round() as u8
    };
    let plain = ColourMap::plain(plain.map(code));
    let Some(file) = &material.diffuse_texture else { return plain };
    let file = path.parent().unwrap_or(Path::new(".")).join(file);
    let name = file.display().to_string();
    let bytes =
        std::fs::read(&file).map_err(|error| Error::new(&name, "cannot be read").source(error));
    bytes.and_then(|bytes| ColourMap::decode(&name, &bytes)).unwrap_or_else(|error| {
        notes.push(format!("{error}; using the material's plain colour"));
        plain
    })
}

fn vectors(numbers: &[f32]) -> impl Iterator<Item = DVec3> {
    numbers.chunks_exact(3).map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into()))
}
