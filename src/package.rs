//! A set of generated files in memory, and the functions that write it to a folder and check a folder against it.
//!
//! The folder belongs to the package as far as its `manifest.json` lists files; everything else in it is foreign and
//! is never changed.

pub mod bindings;
mod cancel;
mod check;
mod content;
mod equality;
mod exchange;
pub mod compile;
mod folder;
mod in_place;
mod leftover;
pub mod manifest;
pub mod probe;
pub mod readme;
mod stage;
mod stamp;
mod write;

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::encode::json;
use crate::error::{Error, Result};
use crate::hash::sha256;
use crate::plan::{Container, TableFormat};
use crate::tables::container::Shape;

pub use cancel::Cancel;
pub use check::{Report, check};
pub use content::Content;
pub use leftover::LeftBehind;
pub use stamp::Stamp;
pub use write::{Output, WriteReport, is_free, write, write_unless};

/// First line of every generated text file, as a comment, and the key `generated_by` of every generated JSON file.
pub use crate::shader::template::GENERATED as GENERATED_BY;

/// The file that lists all others.
pub const MANIFEST: &str = "manifest.json";

/// Maximum size of such a file that is read, in bytes.
pub const MAX_MANIFEST_BYTES: u64 = 256 << 20;

/// Relative tolerance of numbers in JSON.
pub const JSON_TOLERANCE: f64 = 1e-9;

/// How a file on disk is compared with a fresh one: numbers may differ in their last digits between processors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "compare", rename_all = "lowercase")]
pub enum Equality {
    /// Byte for byte.
    Bytes,
    /// Structure and strings exactly; numbers within `tolerance`, relative to the largest magnitude of the array that
    /// holds them, or to their own.
    Json {
        /// Relative tolerance, [`JSON_TOLERANCE`] unless a file states another.
        tolerance: f64,
    },
    /// Little-endian numbers, each within `tolerance` relative to the largest magnitude of its layer.
    Table {
        /// Format of the numbers.
        format: TableFormat,
        /// Relative tolerance.
        tolerance: f64,
        /// Numbers per layer; 0: the file is one layer.
        layer: usize,
    },
    /// A table in a container: the texels like those of a table, all else byte for byte.
    Container {
        /// Which.
        container: Container,
        /// What it holds.
        shape: Shape,
        /// Relative tolerance.
        tolerance: f64,
    },
}

/// One file of a package.
#[derive(Clone, Debug, PartialEq)]
pub struct PackageFile {
    /// What it holds.
    pub content: Content,
    /// How it is compared.
    pub compare: Equality,
}

/// Generated files by path, relative, with `/`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Package {
    files: BTreeMap<String, PackageFile>,
    /// The command that it is of, once it is sealed.
    generated_by: Option<String>,
    notes: Vec<String>,
    gaps: Vec<Gap>,
}

/// A variant that cannot be built on a surface, and why: a listed fact, not a failure of the others.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Gap {
    /// Name of the surface.
    pub surface: String,
    /// Name of the variant.
    pub variant: String,
    /// Why.
    pub reason: String,
}

impl Gap {
    /// The gaps that the manifest of a package states.
    fn of_package(folder: &Path) -> Result<Vec<Gap>> {
        let found = folder::open(folder, GENERATED_BY)?.map(whole).transpose()?;
        Ok(found.map_or_else(Vec::new, |folder| folder.gaps))
    }
}

/// What `manifest.json` says of one file. Nothing here depends on the last digits of computed numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Listed {
    #[serde(flatten)]
    compare: Equality,
    /// Of files compared byte for byte.
    #[serde(skip_serializing_if = "Option::is_none")]
    sha256: Option<String>,
    /// Of files whose size does not depend on the digits of their numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    bytes: Option<u64>,
}

impl Package {
    /// A package without files.
    pub fn new() -> Package {
        Package::default()
    }

    /// Adds a file. The path is relative, of plain parts with `/`, and new. Its folders must not be files of the package.
    pub fn insert(
        &mut self,
        path: &str,
        bytes: impl Into<Vec<u8>>,
        compare: Equality,
    ) -> Result<()> {
        self.insert_content(path, Content::Bytes(bytes.into()), compare)
    }

    /// Like [`Package::insert`], of what may be in a file.
    pub fn insert_content(
        &mut self,
        path: &str,
        content: Content,
        compare: Equality,
    ) -> Result<()> {
        self.insert_file(path, PackageFile { content, compare })
    }

    /// The files in the order of their paths.
    pub fn files(&self) -> &BTreeMap<String, PackageFile> {
        &self.files
    }

    /// What a user should know of: what was filled, clipped, extruded; and the gaps.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Variants that cannot be built on a surface.
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    /// The bytes of a freshly generated file in memory.
    pub fn bytes(&self, path: &str) -> Option<&[u8]> {
        match &self.files.get(path)?.content {
            Content::Bytes(bytes) => Some(bytes),
            Content::Stored { .. } | Content::Spilled(_) | Content::Kept(_) => None,
        }
    }

    /// Takes over from an output folder the files that its manifest lists, that this package lacks and that `keep`
    /// asks for: what a partial rebuild leaves alone. Returns their paths.
    pub fn overlay(&mut self, out: &Path, keep: impl Fn(&str) -> bool) -> Result<Vec<String>> {
        let Some(old) = folder::open(out, self.generated_by())? else { return Ok(Vec::new()) };
        let old = whole(old)?;
        let mut kept = Vec::new();
        for (path, listed) in old.listed {
            let file = old.root.join(&path);
            if path != MANIFEST && !self.files.contains_key(&path) && keep(&path) && file.is_file()
            {
                let content = Content::Kept(file);
                self.insert_file(&path, PackageFile { content, compare: listed.compare })?;
                kept.push(path);
            }
        }
        Ok(kept)
    }

    /// Adds `manifest.json`: `generated_by`, the given keys in their order, and `files`, which lists all other files. Call it last.
    pub fn seal(&mut self, index: BTreeMap<String, Value>) -> Result<()> {
        self.seal_as(GENERATED_BY, index)
    }

    /// Like [`Package::seal`], for a folder of another command, which `generated_by` names. Both this and `schema_version`,
    /// which is added if it is not given, are the mark by which a later run knows that the folder is ours.
    pub fn seal_as(
        &mut self,
        generated_by: &str,
        mut index: BTreeMap<String, Value>,
    ) -> Result<()> {
        #[derive(Serialize)]
        struct Manifest<'a> {
            generated_by: &'a str,
            #[serde(flatten)]
            index: BTreeMap<String, Value>,
            files: BTreeMap<&'a str, Listed>,
        }
        let error = |cause: &str| Error::new(MANIFEST, cause);
        if let Some(key) = ["generated_by", "files"].iter().find(|key| index.contains_key(**key)) {
            return Err(error(&format!("key \"{key}\" is taken")));
        }
        index.entry("schema_version".to_owned()).or_insert_with(|| manifest::SCHEMA_VERSION.into());
        self.generated_by = Some(generated_by.to_owned());
        let mut files = BTreeMap::new();
        for (path, file) in &self.files {
            files.insert(path.as_str(), listed(file)?);
        }
        let manifest = Manifest { generated_by, index, files };
        self.insert(
            MANIFEST,
            json(MANIFEST, &manifest)?,
            Equality::Json { tolerance: JSON_TOLERANCE },
        )
    }

    /// The command that it is of: `generate`, unless it is sealed for another.
    fn generated_by(&self) -> &str {
        self.generated_by.as_deref().unwrap_or(GENERATED_BY)
    }

    /// Removes the files that `keep` does not ask for.
    fn retain(&mut self, keep: impl Fn(&str) -> bool) {
        self.files.retain(|path, _| keep(path));
    }

    fn insert_file(&mut self, path: &str, file: PackageFile) -> Result<()> {
        let error = |cause: &str| Error::new(format!("generated file \"{path}\""), cause);
        if !is_plain(path) {
            return Err(error("has no plain relative path"));
        }
        let folders = path.match_indices('/').map(|(at, _)| &path[..at]);
        let below = format!("{path}/");
        let holds_others = self
            .files
            .range(below.clone()..)
            .next()
            .is_some_and(|(other, _)| other.starts_with(&below));
        if self.files.contains_key(path) {
            return Err(error("is generated twice"));
        }
        if holds_others || folders.into_iter().any(|folder| self.files.contains_key(folder)) {
            return Err(error("is both a file and a folder"));
        }
        self.files.insert(path.to_owned(), file);
        Ok(())
    }
}

/// A folder that holds one package, not parts of two.
fn whole(folder: folder::Folder) -> Result<folder::Folder> {
    match folder.is_between() {
        false => Ok(folder),
        true => Err(Error::new(
            folder.root.display(),
            "is a package of which a killed run wrote a part",
        )
        .remedy("run generate on it, which completes it")),
    }
}

/// Whether every part of a path is a plain name, so that no file leaves the folder.
fn is_plain(path: &str) -> bool {
    path.split('/')
        .all(|part| !matches!(part, "" | "." | "..") && !part.contains(['\\', ':', '\0']))
}

fn listed(file: &PackageFile) -> Result<Listed> {
    let PackageFile { content, compare } = file;
    let (sha256, bytes) = match compare {
        Equality::Json { .. } => (None, None),
        Equality::Table { .. } | Equality::Container { .. } => (None, Some(content.byte_count()?)),
        Equality::Bytes => {
            let bytes = content.read()?;
            (Some(sha256(&bytes)), Some(bytes.len() as u64))
        }
    };
    Ok(Listed { compare: *compare, sha256, bytes })
}
