//! Reads Wavefront OBJ.

use std::cell::RefCell;
use std::path::Path;

use diffraction_shaders::error::{Error, Result};
use glam::{DVec2, DVec3};

use super::named::{MAX_TRIANGLES, MAX_VERTICES, Named, within};
use super::raw::Raw;
use crate::drivers::ColourMap;

/// All objects of a file in one mesh. The colour is the first material's texture or plain colour.
pub(super) fn read(path: &Path) -> Result<Raw> {
    let name = path.display().to_string();
    let fail = |error: tobj::LoadError| Error::new(&name, "cannot be read as OBJ").source(error);
    let (files, bytes) = Named::open(path)?;
    counted(&bytes).map_err(|cause| Error::new(&name, cause))?;
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    // the reader's own error has no place for a reason
    let refused = RefCell::new(None);
    let named = RefCell::new(files);
    let (models, materials) = tobj::load_obj_buf(&mut &bytes[..], &options, |library| {
        let read = named.borrow_mut().file(&library.to_string_lossy());
        let read = read.and_then(|bytes| {
            let subject = library.display();
            tobj::load_mtl_buf(&mut &bytes[..])
                .map_err(|error| Error::new(subject, "cannot be read as MTL").source(error))
        });
        read.map_err(|error| {
            refused.borrow_mut().get_or_insert(error);
            tobj::LoadError::OpenFileFailed
        })
    })
    .map_err(fail)?;
    drop(bytes);
    let (mut files, refused) = (named.into_inner(), refused.into_inner());
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
        let (vertices, triangles) = (mesh.positions.len() / 3, mesh.indices.len() / 3);
        let limits = within(raw.positions.len() + vertices, MAX_VERTICES, "vertices")
            .and_then(|()| within(raw.triangles.len() + triangles, MAX_TRIANGLES, "triangles"));
        limits.map_err(|cause| Error::new(&name, cause))?;
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
                raw.colour = colour(&name, &mut files, material, &mut raw.notes);
            }
        }
        Err(error) => {
            let why = refused.map_or_else(|| error.to_string(), |error| error.to_string());
            raw.notes.push(format!("{name}: its materials cannot be read: {why}; using grey"));
        }
    }
    Ok(raw)
}

/// Checks the numbers of vertices and of corners before anything is built from them.
fn counted(text: &[u8]) -> Result<(), String> {
    let (mut vertices, mut corners) = (0, 0);
    for line in text.split(|byte| *byte == b'\n') {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v" | b"vt" | b"vn") => vertices += 1,
            Some(b"f" | b"l" | b"p") => corners += words.count(),
            _ => {}
        }
    }
    within(vertices, 3 * MAX_VERTICES, "positions, normals and texture coordinates")?;
    within(corners, 3 * MAX_TRIANGLES, "corners of faces")
}

fn colour(
    name: &str,
    files: &mut Named,
    material: &tobj::Material,
    notes: &mut Vec<String>,
) -> ColourMap {
    let plain = material.diffuse.unwrap_or([0.5; 3]);
    let code = |c: f32| {
        (255.0 * diffraction_shaders::optics::colour::srgb_encode(f64::from(c))).round() as u8
    };
    let plain = ColourMap::plain(plain.map(code));
    let Some(file) = &material.diffuse_texture else { return plain };
    let about = format!("{name}: its texture");
    let bytes =
        files.file(file).map_err(|error| Error::new(&about, "cannot be read").source(error));
    bytes.and_then(|bytes| ColourMap::decode(&about, &bytes)).unwrap_or_else(|error| {
        notes.push(format!("{error}; using the material's plain colour"));
        plain
    })
}

fn vectors(numbers: &[f32]) -> impl Iterator<Item = DVec3> {
    numbers.chunks_exact(3).map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into()))
}
