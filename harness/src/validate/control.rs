//! Whether a validator can be believed: it must accept a small package of ours, and reject it once something in it is wrong.
//!
//! A program on the PATH may be anything. One that always succeeds would otherwise pass for a validator of everything.

use std::fs;
use std::path::Path;

use diffraction_cli::interrupt::TemporaryFolder;
use diffraction_shaders::diagnostic::Diagnostics;
use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::package::{Package, write};
use diffraction_shaders::{Compiler, Plan};

use crate::process::Fault;

use super::{Tool, Trouble};

/// A surface and a variant that cost almost nothing; its few terms are accepted. It sends much light aside in both axes, so that a flipped one shows.
const PLAN: &str = r#"schema = 1
[[surface]]
name = "control"
grating = { kind = "crossed", x = { kind = "blazed", period_um = 1.2, height_um = 0.15, pixels = 16 }, y = { kind = "blazed", period_um = 1.2, height_um = 0.14, pixels = 16 } }
[variants]
terms = [3]
accept_error = true
wavelengths = [{ min_nm = 500, max_nm = 600, step_nm = 50 }]
[targets]
emit = ["wgsl", "glsl450", "spirv", "hlsl", "msl"]
"#;

/// A file that a tool must accept, and a change after which it must reject it.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    /// Name of the file in the variant's folder.
    pub file: &'static str,
    /// Name of the file that is changed, often the same.
    pub changed: &'static str,
    /// The change.
    pub change: Change,
}

/// A change of a file.
#[derive(Clone, Copy, Debug)]
pub enum Change {
    /// The first of these texts becomes the second, at its first place.
    Text(&'static str, &'static str),
    /// SPIR-V: the first instruction gets the length 0.
    NoLength,
}

impl Control {
    /// A change of the checked file's text.
    pub const fn text(file: &'static str, from: &'static str, to: &'static str) -> Control {
        Control { file, changed: file, change: Change::Text(from, to) }
    }
}

impl Change {
    /// The changed file; `None` where the change finds no place.
    fn of(self, bytes: &[u8]) -> Option<Vec<u8>> {
        match self {
            Change::Text(from, to) => {
                let text = std::str::from_utf8(bytes).ok().filter(|text| text.contains(from))?;
                Some(text.replacen(from, to, 1).into_bytes())
            }
            Change::NoLength => {
                let mut bytes = bytes.to_vec();
                // after a header of five words; the upper half of an instruction's first word is its length
                bytes.get_mut(22..24)?.fill(0);
                Some(bytes)
            }
        }
    }
}

/// The small package.
pub(super) fn package() -> Result<Package> {
    let broken = |errors: Diagnostics| {
        Error::new("the package of controls", "is not compiled").source(errors)
    };
    let plan = Plan::parse(PLAN, Path::new("controls.toml"))?;
    Compiler::new(&plan).compile().map_err(broken)
}

fn no_folder(error: std::io::Error) -> Error {
    Error::new("a temporary folder", "cannot be used").source(error)
}

/// Whether the tool judges the small package rightly. The outer error is ours, the inner one the tool's.
pub(super) fn believed(tool: &dyn Tool, package: &Package) -> Result<Result<(), Trouble>> {
    let folder = TemporaryFolder::new().map_err(no_folder)?;
    let out = folder.path().join("package");
    write(package, &out)?;
    let manifest = package
        .files()
        .keys()
        .find(|name| name.starts_with("shaders/") && name.ends_with("/manifest.json"));
    let variant = manifest.and_then(|name| out.join(name).parent().map(Path::to_path_buf));
    let variant = variant.ok_or_else(|| Error::new("the package of controls", "has no variant"))?;
    for control in tool.controls() {
        let unusable = |error| Error::new(control.changed, "cannot be used").source(error);
        let judge = || tool.check(&variant.join(control.file));
        match judge() {
            Ok(_) => {}
            Err(Fault::TimedOut(limit)) => return Ok(Err(silent(limit.as_secs_f64()))),
            Err(fault) => {
                let said = beginning(&fault.to_string());
                let why = format!("it rejects a sound {} of ours: {said}", control.file);
                return Ok(Err(Trouble::NotBelieved(why)));
            }
        }
        let changed = variant.join(control.changed);
        let sound = fs::read(&changed).map_err(unusable)?;
        let wrong = control.change.of(&sound).ok_or_else(|| {
            Error::new(control.changed, format!("the change {:?} finds no place", control.change))
        })?;
        fs::write(&changed, wrong).map_err(unusable)?;
        match judge() {
            Err(Fault::Refused(_)) => {}
            Err(Fault::TimedOut(limit)) => return Ok(Err(silent(limit.as_secs_f64()))),
            Err(fault) => {
                return Ok(Err(Trouble::NotBelieved(beginning(&fault.to_string()))));
            }
            Ok(_) => {
                let what = match control.change {
                    Change::Text(from, to) => format!("with `{to}` for `{from}`"),
                    Change::NoLength => "with an instruction of length 0".to_owned(),
                };
                let why = format!("it accepts a {} of ours {what}", control.changed);
                return Ok(Err(Trouble::NotBelieved(why)));
            }
        }
        fs::write(&changed, sound).map_err(unusable)?;
    }
    Ok(Ok(()))
}

fn silent(seconds: f64) -> Trouble {
    Trouble::NotAnswering(format!("did not end within {seconds} s"))
}

/// The beginning of a message that may be a megabyte long.
fn beginning(text: &str) -> String {
    let lines: Vec<&str> = text.lines().take(5).collect();
    lines.join("\n").chars().take(500).collect()
}
