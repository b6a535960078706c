//! Compares the manifest with what spirv-cross finds in the SPIR-V beside it.
//!
//! The manifest is written from naga's reflection. spirv-cross shares no code with naga, so an error would have to be in both.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

use diffraction_shaders::input::read_file;
use diffraction_shaders::package::MAX_MANIFEST_BYTES;
use serde_json::Value;

use crate::process::{Fault, accepted};

use super::{Change, Control, Reads, Tool, Trouble, trouble};

/// Compares entry points, sets, bindings, dimensions and uniform offsets of SPIR-V with the `manifest.json` beside it.
pub struct Reflection {
    program: Result<PathBuf, Trouble>,
    time_limit: Duration,
}

impl Reflection {
    /// Looks for spirv-cross on the PATH.
    #[must_use]
    pub fn new(time_limit: Duration) -> Reflection {
        Reflection { program: trouble::program("spirv-cross"), time_limit }
    }
}

impl Tool for Reflection {
    fn name(&self) -> &str {
        "reflection"
    }

    fn remedy(&self) -> String {
        "apt-get install spirv-cross".to_owned()
    }

    fn version(&self) -> Result<String, Trouble> {
        self.program.clone().map(|_| "spirv-cross --reflect against manifest.json".to_owned())
    }

    fn reads(&self, name: &str) -> bool {
        Reads::Spirv.name(name)
    }

    fn controls(&self) -> &'static [Control] {
        &[Control {
            file: "diffraction.frag.spv",
            changed: "manifest.json",
            change: Change::Text("\"size\": 32", "\"size\": 48"),
        }]
    }

    fn check(&self, file: &Path) -> Result<Option<f64>, Fault> {
        let program = self.program.as_ref().map_err(ToString::to_string)?;
        let file = fs::canonicalize(file).map_err(|error| error.to_string())?;
        let manifest = read_file(&file.with_file_name("manifest.json"), MAX_MANIFEST_BYTES)
            .map_err(|error| format!("manifest.json beside it cannot be read: {error}"))?;
        let manifest = json("manifest.json", &String::from_utf8_lossy(&manifest))?;
        let mut reflect = Command::new(program);
        let reflected = accepted(reflect.arg(&file).arg("--reflect"), self.time_limit)?;
        let reflected = json("the output of spirv-cross", &reflected)?;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let differences = differences(&manifest, &name, &reflected);
        if differences.is_empty() { Ok(None) } else { Err(differences.join("\n").into()) }
    }
}

fn json(what: &str, text: &str) -> Result<Value, String> {
    serde_json::from_str(text).map_err(|error| format!("{what} is not valid JSON: {error}"))
}

/// All differences between the manifest and the reflection, one line each.
fn differences(manifest: &Value, file: &str, reflected: &Value) -> Vec<String> {
    let mut files = array(&manifest["targets"], "spirv").iter();
    let Some(entry) = files.find(|entry| entry["file"] == file) else {
        return vec![format!("the manifest lists no SPIR-V file `{file}`")];
    };
    let mut found = Vec::new();
    let said: BTreeSet<String> = array(entry, "entry_points")
        .iter()
        .map(|e| format!("{} {}", text(&e["emitted_name"]), text(&e["stage"])))
        .collect();
    let read: BTreeSet<String> = array(reflected, "entryPoints")
        .iter()
        .map(|e| {
            let mode = text(&e["mode"]);
            let stage = match mode {
                "vert" => "vertex",
                "frag" => "fragment",
                other => other,
            };
            format!("{} {stage}", text(&e["name"]))
        })
        .collect();
    disagreements(&mut found, "entry points", &said, &read);
    disagreements(
        &mut found,
        "resources",
        &said_resources(manifest, entry),
        &read_resources(reflected),
    );
    found
}

fn disagreements(
    found: &mut Vec<String>,
    what: &str,
    said: &BTreeSet<String>,
    read: &BTreeSet<String>,
) {
    let lines =
        |set: &BTreeSet<String>| set.iter().map(String::as_str).collect::<Vec<_>>().join("; ");
    if said != read {
        let said_only = lines(&said.difference(read).cloned().collect());
        let read_only = lines(&read.difference(said).cloned().collect());
        found.push(format!("{what}: the manifest has `{said_only}`, the file `{read_only}`"));
    }
}

/// `name set.binding what` of every resource of a file, and the members of its uniform blocks.
fn said_resources(manifest: &Value, entry: &Value) -> BTreeSet<String> {
    let mut said = BTreeSet::new();
    for named in array(entry, "bindings") {
        let source = &named["source_name"];
        let name = text(&named["emitted_name"]);
        let binding = array(manifest, "bindings").iter().find(|b| b["name"] == *source);
        let binding = binding.unwrap_or(&Value::Null);
        // the file's own entry and the general list must agree
        let numbers = format!("{}.{}", binding["group"], binding["binding"]);
        let what = match text(&binding["kind"]) {
            "texture" => format!("texture {}", text(&binding["dimension"])),
            other => other.to_owned(),
        };
        said.insert(format!("{name} {numbers} {what}"));
        said.insert(format!("{name} {}.{} as emitted", named["group"], named["emitted_binding"]));
        let block = array(manifest, "uniforms").iter().find(|block| block["name"] == *source);
        if let Some(block) = block {
            said.insert(format!("{name} {} bytes", block["size"]));
            for member in array(block, "members") {
                let (member_name, ty) = (text(&member["name"]), text(&member["type"]));
                said.insert(format!("{name}.{member_name} {ty} at {}", member["offset"]));
            }
        }
    }
    said
}

fn read_resources(reflected: &Value) -> BTreeSet<String> {
    let mut read = BTreeSet::new();
    let kinds = [
        "ubos",
        "separate_images",
        "separate_samplers",
        "textures",
        "ssbos",
        "images",
        "push_constants",
    ];
    for kind in kinds {
        for resource in array(reflected, kind) {
            let name = text(&resource["name"]);
            let numbers = format!("{}.{}", resource["set"], resource["binding"]);
            read.insert(format!("{name} {numbers} as emitted"));
            if kind != "ubos" {
                let dimension = match text(&resource["type"]) {
                    "texture2D" => "texture 2d",
                    "texture2DArray" => "texture 2d-array",
                    "texture3D" => "texture 3d",
                    "sampler" => "sampler",
                    other => other,
                };
                read.insert(format!("{name} {numbers} {dimension}"));
                continue;
            }
            read.insert(format!("{name} {numbers} uniform"));
            read.insert(format!("{name} {} bytes", resource["block_size"]));
            for (member, offset, ty) in members(reflected, text(&resource["type"])) {
                read.insert(format!("{name}.{member} {ty} at {offset}"));
            }
        }
    }
    read
}

/// Members of a block. naga wraps a structure into a block with one member, which is unwrapped here.
fn members<'a>(reflected: &'a Value, ty: &str) -> Vec<(&'a str, u64, &'static str)> {
    let outer = array(&reflected["types"][ty], "members");
    let inner = match outer {
        [only] if reflected["types"].get(text(&only["type"])).is_some() => {
            array(&reflected["types"][text(&only["type"])], "members")
        }
        _ => outer,
    };
    let names = BTreeMap::from([
        ("vec4", "vec4f"),
        ("ivec4", "vec4i"),
        ("uvec4", "vec4u"),
        ("mat4", "mat4x4f"),
    ]);
    let member = |member: &'a Value| {
        let ty = names.get(text(&member["type"])).copied().unwrap_or("?");
        (text(&member["name"]), member["offset"].as_u64().unwrap_or(u64::MAX), ty)
    };
    inner.iter().map(member).collect()
}

fn array<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}
