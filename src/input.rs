//! Reads all input files: a plan, and the spectra and height fields that it names.
//!
//! Every file is read once and hashed as it is read. So the hash always belongs to the numbers that are computed, even
//! if the file changes meanwhile. Later modules receive the bytes; no other module opens an input.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Read};
use std::path::Path;
use std::sync::OnceLock;

use serde_json::json;

use crate::disk::open_regular;
use crate::error::{Error, Result};
use crate::hash::{of_value, sha256};
use crate::light::{LampSearch, Lights, Panorama};
use crate::optics::{Index, notes, spectrum};
use crate::pattern::{Anisotropy, GivenRanges, PatternMap, Stencil};
use crate::plan::{Data, FileSource, Medium, Plan, SurfaceSource, SurfaceSpec};
use crate::surface::read::{MAX_FILE_BYTES, Reading};
use crate::surface::{self, Origin, Surface};

/// Maximum size of a plan, in bytes.
pub const MAX_PLAN_BYTES: u64 = 4 << 20;

/// Maximum size of a panorama, in bytes: more than one of the most rows takes.
const MAX_PANORAMA_BYTES: u64 = 1 << 30;

/// Maximum size of a picture, in bytes: more than a pattern map of the most texels takes.
const MAX_PICTURE_BYTES: u64 = 1 << 30;

/// Maximum size of a table of an illuminant or of a medium, in bytes.
const MAX_DATA_BYTES: u64 = 1 << 20;

/// Reads and checks a plan, and the tables of illuminants and media that it names. Paths are relative to the plan's folder. Returns all
/// errors; errors of the plan itself are in the order of its text.
pub fn read_plan(path: &Path) -> Result<Plan, Vec<Error>> {
    let text = read_text(path, PLAN_REMEDY).map_err(|error| vec![error])?;
    let mut plan = Plan::parse_all(&text, path)?;
    let mut known = BTreeMap::new();
    let mut errors = Vec::new();
    let folder = plan.folder.clone();
    let optics = plan.variants.iter_mut().map(|variant| &mut variant.optics);
    let own = plan.surfaces.iter_mut().map(|surface| surface.optics.values_mut());
    for optics in optics.chain([&mut plan.optics]).chain(own) {
        let mut read = |data: &mut Data, of: &Kind| {
            let read = known.entry((of.what, data.name().to_owned())).or_insert_with(|| {
                read_data(path, &folder, data, of).map_err(|error| errors.push(error)).ok()
            });
            if let Some(read) = read {
                *data = read.clone();
            }
        };
        if !spectrum::is_named(optics.illuminant.name()) {
            read(&mut optics.illuminant, &ILLUMINANT);
        }
        optics.media_mut().for_each(|data| read(data, &MEDIUM));
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    add_notes(&mut plan);
    Ok(plan)
}

/// Adds notes about what surfaces are made of. What cannot be built on a surface is found there.
fn add_notes(plan: &mut Plan) {
    let own = plan.surfaces.iter().map(|surface| surface.optics.over(&plan.optics));
    let all = plan.variants.iter().map(|variant| variant.optics.clone()).chain(own);
    let mut known = BTreeSet::new();
    for optics in all.filter(|optics| !optics.is_plain()) {
        let media: Vec<String> = optics.media().iter().map(|(_, medium)| medium.name()).collect();
        if known.insert((media, optics.illuminant.name().to_owned())) {
            let new = notes(&optics).into_iter().filter(|note| !plan.notes.contains(note));
            let new: Vec<String> = new.collect();
            plan.notes.extend(new);
        }
    }
}

/// Reads a whole file. Whatever is not a regular file is refused before it is opened, since a pipe or a device might never
/// end or never begin. So is a file of more than `max` bytes, and one that turns out to have more than it stated.
pub fn read_file(path: &Path, max: u64) -> io::Result<Vec<u8>> {
    let refused = |cause: String| io::Error::new(io::ErrorKind::InvalidInput, cause);
    let found = fs::metadata(path)?;
    if !found.is_file() {
        let what = if found.is_dir() { "is a folder" } else { "is not a regular file" };
        return Err(refused(what.to_owned()));
    }
    let above =
        |bytes: u64| refused(format!("has {bytes} bytes or more, above the limit of {max}"));
    if found.len() > max {
        return Err(above(found.len()));
    }
    let mut bytes = Vec::with_capacity(found.len() as usize);
    open_regular(path)?.take(max + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > max {
        true => Err(above(bytes.len() as u64)),
        false => Ok(bytes),
    }
}

const PLAN_REMEDY: &str = "check the path, or name another plan with --plan";
const LIGHTS_REMEDY: &str = "check the path; --lights names a TOML file of lights";

/// Reads a TOML file.
fn read_text(path: &Path, remedy: &str) -> Result<String> {
    let error = |cause: &str| Error::new(path.display(), cause);
    if path.is_dir() {
        return Err(error("is a folder")
            .remedy(format!("name the file, such as {}", path.join("plan.toml").display())));
    }
    let bytes = read_file(path, MAX_PLAN_BYTES).map_err(|e| {
        let check = "check that this is the right file";
        match e.kind() {
            io::ErrorKind::InvalidInput if path.is_file() => {
                error("is larger than 4 MiB, the limit for a TOML file").remedy(check)
            }
            io::ErrorKind::InvalidInput => error("is not a regular file").remedy(check),
            _ => error("cannot be read").source(e).remedy(remedy),
        }
    })?;
    String::from_utf8(bytes).map_err(|e| {
        let valid = e.utf8_error().valid_up_to();
        let line = e.as_bytes()[..valid].iter().filter(|byte| **byte == b'\n').count() + 1;
        Error::new(format!("{}:{line}", path.display()), "is not UTF-8 text")
            .remedy("save it as UTF-8")
    })
}

/// Reads and checks a `lights.toml`. Returns all errors, in the order of its text.
pub fn read_lights(path: &Path) -> Result<Lights, Vec<Error>> {
    read_lights_with(path, LampSearch::None)
}

/// The same. `lamps`: what happens to lamps in a map of which the file does not say it.
pub fn read_lights_with(path: &Path, lamps: LampSearch) -> Result<Lights, Vec<Error>> {
    let text = read_text(path, LIGHTS_REMEDY).map_err(|error| vec![error])?;
    let folder = path.parent().unwrap_or(Path::new(""));
    Lights::parse_with(&text, path, &|file| read_panorama(&folder.join(file)), lamps)
}

/// Reads a panorama, with notes about it.
fn read_panorama(path: &Path) -> Result<(Panorama, Vec<String>)> {
    let place = path.display().to_string();
    let bytes = read_file(path, MAX_PANORAMA_BYTES).map_err(|e| match e.kind() {
        io::ErrorKind::InvalidInput => {
            Error::new(&place, e).remedy("name an .exr or .hdr file; it is relative to this file")
        }
        _ => Error::new(&place, "cannot be read")
            .source(e)
            .remedy("check the path; it is relative to this file"),
    })?;
    Panorama::decode(&bytes, &place)
}

/// Reads a pattern map from a PNG file.
pub fn read_pattern(path: &Path, given: &GivenRanges) -> Result<PatternMap> {
    let (bytes, place) = read_picture(path)?;
    PatternMap::decode(&bytes, given, &place)
}

/// Reads glTF's texture of anisotropy from a PNG file.
pub fn read_anisotropy(path: &Path, of: &Anisotropy) -> Result<PatternMap> {
    let (bytes, place) = read_picture(path)?;
    PatternMap::from_anisotropy(&bytes, of, &place)
}

/// Reads a picture that shapes a pattern from a PNG file.
pub fn read_stencil(path: &Path, invert: bool) -> Result<Stencil> {
    let (bytes, place) = read_picture(path)?;
    Stencil::decode(&bytes, invert, &place)
}

/// The bytes of a picture, and its name for errors.
fn read_picture(path: &Path) -> Result<(Vec<u8>, String)> {
    let place = path.display().to_string();
    let bytes = read_file(path, MAX_PICTURE_BYTES).map_err(|e| {
        Error::new(&place, "cannot be read").source(e).remedy("name a PNG file that can be read")
    })?;
    Ok((bytes, place))
}

/// What a file of the plan's optics is for.
struct Kind {
    what: &'static str,
    /// What it is, if there is no such file.
    absent: &'static str,
    subject: fn(&Data) -> String,
    remedy: &'static str,
    /// Whether the content can be used.
    check: fn(&Data) -> Result<()>,
}

const ILLUMINANT: Kind = Kind {
    what: "an illuminant table",
    absent: "is neither a known illuminant nor a file relative to the plan's folder",
    subject: spectrum::illuminant_subject,
    remedy: spectrum::ILLUMINANT_REMEDY,
    // forms and commands check it, each with its own range
    check: |_| Ok(()),
};

const MEDIUM: Kind = Kind {
    what: "a table of n and k",
    absent: "is not a file relative to the plan's folder",
    subject: nk,
    remedy: "name a CSV file with columns wavelength_nm, n and k",
    check: |data| Index::new(&nk(data), &Medium::File(data.clone())).map(drop),
};

fn nk(data: &Data) -> String {
    format!("optics: nk = {:?}", data.name())
}

/// Reads a file of the plan's optics. `plan`: the plan's path, for errors.
fn read_data(plan: &Path, folder: &Path, data: &Data, of: &Kind) -> Result<Data> {
    let path = folder.join(data.name());
    let fail = |cause: String| {
        let subject = format!("{}: {}", plan.display(), (of.subject)(data));
        Error::new(subject, cause).remedy(of.remedy)
    };
    if !path.is_file() {
        return Err(fail(of.absent.to_owned()));
    }
    let bytes = read_file(&path, MAX_DATA_BYTES).map_err(|e| match e.kind() {
        io::ErrorKind::InvalidInput => {
            fail(format!("is larger than 1 MiB, the limit for {}", of.what))
                .remedy("check that this is the right file; a few thousand lines suffice")
        }
        _ => fail("cannot be read".to_owned()).source(e),
    })?;
    let data = data.clone().with_content(bytes);
    (of.check)(&data).map_err(|error| {
        let again = Error::new(plan.display(), error.message());
        again.remedy(error.advice().unwrap_or(of.remedy))
    })?;
    Ok(data)
}

/// A surface of a plan with the bytes of its file. They are decoded when the heights are first needed.
#[derive(Debug)]
pub struct SurfaceInput {
    spec: SurfaceSpec,
    bytes: Option<Vec<u8>>,
    identity: String,
    prepared: OnceLock<(Surface, Origin)>,
}

impl SurfaceInput {
    /// Reads the file of a surface, if it has one. A synthetic surface has no file.
    pub fn read(spec: &SurfaceSpec) -> Result<SurfaceInput> {
        let bytes = match &spec.source {
            SurfaceSource::Grating(_) => None,
            SurfaceSource::File(file) => Some(height_bytes(file, &surface::subject(spec))?),
        };
        let identity = identity(spec, bytes.as_deref());
        Ok(SurfaceInput { spec: spec.clone(), bytes, identity, prepared: OnceLock::new() })
    }

    /// The surface as planned.
    pub fn spec(&self) -> &SurfaceSpec {
        &self.spec
    }

    /// Hash of everything that the heights are made from: the formula, or the file's bytes, scale and preparation. The
    /// surface's name and the path of the file are not part of it.
    pub fn identity(&self) -> &str {
        &self.identity
    }

    /// Bytes of memory that it takes: the file, and the heights once they are decoded.
    pub fn held_bytes(&self) -> u64 {
        let heights = self.prepared.get().map_or(0, |(surface, _)| surface.field.byte_count());
        self.bytes.as_ref().map_or(0, Vec::len) as u64 + heights
    }

    /// The prepared heights. They are decoded only once.
    pub fn surface(&self) -> Result<&Surface> {
        self.surface_with_origin().map(|(surface, _)| surface)
    }

    /// Like [`SurfaceInput::surface`], with facts about the file itself.
    pub fn surface_with_origin(&self) -> Result<&(Surface, Origin)> {
        if let Some(prepared) = self.prepared.get() {
            return Ok(prepared);
        }
        let prepared = surface::prepare(&self.spec, self.bytes.as_deref())?;
        Ok(self.prepared.get_or_init(|| prepared))
    }
}

/// Reads the files of all surfaces, or returns all their errors.
pub fn read_surfaces(specs: &[SurfaceSpec]) -> Result<Vec<SurfaceInput>, Vec<Error>> {
    let (mut inputs, mut errors) = (Vec::new(), Vec::new());
    for spec in specs {
        match SurfaceInput::read(spec) {
            Ok(input) => inputs.push(input),
            Err(error) => errors.push(error),
        }
    }
    if errors.is_empty() {
        return Ok(inputs);
    }
    errors.extend(inputs.iter().filter_map(|input| input.surface().err()));
    Err(errors)
}

/// Reads and prepares one surface.
pub fn load_surface(spec: &SurfaceSpec) -> Result<Surface> {
    let input = SurfaceInput::read(spec)?;
    input.surface()?;
    let prepared = input.prepared.into_inner();
    prepared
        .map(|(surface, _)| surface)
        .ok_or_else(|| Error::new(surface::subject(spec), "has no heights"))
}

/// Reads and decodes the file of surface `name`, without preparing the heights.
pub fn read_heights(source: &FileSource, name: &str) -> Result<Reading> {
    let bytes = height_bytes(source, &surface::read::subject(name, &source.path))?;
    surface::read::parse(source, name, &bytes)
}

/// The whole file. Its size is checked before memory is allocated.
fn height_bytes(source: &FileSource, subject: &str) -> Result<Vec<u8>> {
    let error = |cause: &str| Error::new(subject, cause);
    surface::read::check_source(source, subject)?;
    let meta = fs::metadata(&source.path).map_err(|e| {
        error("cannot be read")
            .source(e)
            .remedy("check `file`; it is relative to the folder of the plan")
    })?;
    if !meta.is_file() {
        return Err(
            error("is not a regular file").remedy("set `file` to the path of a height field")
        );
    }
    surface::read::check_extension(&source.path, subject)?;
    if meta.len() > MAX_FILE_BYTES {
        let cause =
            format!("the file has {} bytes, above the limit of {MAX_FILE_BYTES}", meta.len());
        return Err(error(&cause).remedy("crop the surface"));
    }
    read_file(&source.path, MAX_FILE_BYTES)
        .map_err(|e| error("cannot be read").source(e).remedy("check its permissions"))
}

fn identity(spec: &SurfaceSpec, bytes: Option<&[u8]>) -> String {
    let SurfaceSpec { name: _, source, rotate_deg, level, clip_percent, optics: _ } = spec;
    let source = match source {
        SurfaceSource::Grating(grating) => json!(grating),
        SurfaceSource::File(file) => {
            // every key of the file but its path
            let keys = FileSource { path: Default::default(), ..file.clone() };
            json!([sha256(bytes.unwrap_or_default()), keys])
        }
    };
    of_value(&json!([source, rotate_deg, level, clip_percent]))
}
