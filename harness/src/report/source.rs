//! Reads a folder of results.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path};

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::input::read_file;

use crate::results::{self, Record};

/// Maximum size of a picture, in bytes.
const MAX_PICTURE: u64 = 64 << 20;
/// First bytes of a PNG file (ISO/IEC 15948, 5.2).
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Records of a folder, with the pictures that they name.
#[derive(Clone, Debug, Default)]
pub struct Folder {
    /// Its name in the page.
    pub name: String,
    /// The records, in the order of the file.
    pub records: Vec<Record>,
    /// Pictures by their paths, or why they cannot be read. A path that is not listed was left out on purpose.
    pub pictures: BTreeMap<String, std::result::Result<Vec<u8>, String>>,
}

/// Reads `records.jsonl` of a folder and, if wanted, the pictures that it names.
pub fn read(folder: &Path, pictures: bool) -> Result<Folder> {
    let path = folder.join(results::FILE);
    if !path.is_file() {
        return Err(Error::new(folder.display(), format!("has no {}", results::FILE))
            .remedy("give a folder that compare, bench, testbench or tune wrote with --out"));
    }
    let records = results::read(&path)?;
    let mut found = BTreeMap::new();
    for place in records.iter().flat_map(places).filter(|_| pictures) {
        if !found.contains_key(place) {
            found.insert(place.to_owned(), picture(folder, place));
        }
    }
    let name = folder
        .file_name()
        .map_or_else(|| folder.display().to_string(), |name| name.to_string_lossy().into_owned());
    Ok(Folder { name, records, pictures: found })
}

/// The pictures that a record names.
fn places(record: &Record) -> Vec<&str> {
    match record {
        Record::Compare(compare) => compare.pictures.iter().flatten().map(String::as_str).collect(),
        Record::Testbench(bench) => bench.svg.iter().map(String::as_str).collect(),
        _ => Vec::new(),
    }
}

/// Reads a picture under the folder. A record must not bring any other file into the page.
fn picture(folder: &Path, place: &str) -> std::result::Result<Vec<u8>, String> {
    let inside = Path::new(place).components().all(|part| matches!(part, Component::Normal(_)));
    if !inside || place.is_empty() {
        return Err("is outside the folder".into());
    }
    // links are followed, but not out of the folder
    let real = |path: &Path| fs::canonicalize(path).map_err(|e| e.to_string());
    let (root, path) = (real(folder)?, real(&folder.join(place))?);
    if !path.starts_with(root) {
        return Err("leads out of the folder through a link".into());
    }
    let bytes = read_file(&path, MAX_PICTURE).map_err(|e| e.to_string())?;
    let known = match place.rsplit_once('.') {
        Some((_, "png")) => bytes.starts_with(PNG),
        Some((_, "svg")) => std::str::from_utf8(&bytes).is_ok_and(|text| text.contains("<svg")),
        _ => false,
    };
    if known { Ok(bytes) } else { Err("is not a PNG or SVG picture".into()) }
}
