//! Reads meshes from files.

use std::path::Path;

use diffraction_shaders::error::{Error, Result};

use super::mesh::Mesh;
use super::{gltf, obj};

/// Reads a mesh from a `.gltf`, `.glb` or `.obj` file.
pub fn read(path: &Path) -> Result<Mesh> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let raw = match extension.to_ascii_lowercase().as_str() {
        "gltf" | "glb" => gltf::read(path)?,
        "obj" => obj::read(path)?,
        _ => {
            let cause = "the name must end in .gltf, .glb or .obj";
            return Err(Error::new(path.display(), cause).remedy("convert the file"));
        }
    };
    raw.mend(&path.display().to_string())
}
