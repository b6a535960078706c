//! One function per target language.
//!
//! Common to all targets: clip space is as in the WGSL text (y up, depth 0 … 1) and is not rewritten, since matrices
//! belong to the engine; loops get no artificial bounds; overrides are resolved before a writer runs. Run-time bounds
//! checks are off: the templates keep every index and texel coordinate in range by construction, and checks in the
//! innermost loop cost up to half of the speed. WGSL keeps the checks that its implementation adds.

mod glsl;
mod spirv;
mod wgsl;

use std::fmt;

use naga::{
    AddressSpace, TypeInner,
    proc::{BoundsCheckPolicies, BoundsCheckPolicy},
};
use serde::Serialize;

use crate::{
    error::{self, Error, Result},
    module::{Module, Stage},
    plan::Target,
};

/// The entry point that bears no name in its file names, next to the vertex shader.
const MAIN_FRAGMENT: &str = "map";
const MAIN_VERTEX: &str = "vert";

/// One file of one target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EmittedFile {
    /// File name, without a folder.
    pub name: String,
    /// Its target.
    pub target: Target,
    /// Text in UTF-8, or the words of SPIR-V in little-endian order.
    pub bytes: Vec<u8>,
    /// Those in the file, in the order of the template text; only WGSL has more than one.
    pub entry_points: Vec<EntryPoint>,
    /// The resources that these entry points read, in the order of the template text.
    pub bindings: Vec<BindingName>,
}

impl EmittedFile {
    /// Names of the uniform blocks, as an engine has to ask for them.
    pub fn uniform_blocks(&self) -> impl Iterator<Item = &str> {
        let blocks = self.bindings.iter().filter(|b| b.kind == BindingKind::UniformBlock);
        blocks.map(|block| block.emitted_name.as_str())
    }
}

/// A function that a pipeline can begin with.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct EntryPoint {
    /// Vertex or fragment.
    pub stage: Stage,
    /// Its name in the templates.
    pub source_name: String,
    /// Its name in the file.
    pub emitted_name: String,
}

/// What is bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BindingKind {
    /// A buffer of uniforms.
    UniformBlock,
    /// A sampled texture; in GLSL a combined sampler.
    Texture,
    /// A sampler.
    Sampler,
}

/// The name that a target gives to a resource.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct BindingName {
    /// Name of the variable in the templates.
    pub source_name: String,
    /// Name by which the API finds it: of the uniform block or of the variable. For a sampler in GLSL, the texture
    /// that it is combined with.
    pub emitted_name: String,
    /// Name of the variable inside a GLSL uniform block.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub member_name: Option<String>,
    /// Bind group or descriptor set in the templates.
    pub group: u32,
    /// Binding in the templates.
    pub binding: u32,
    /// Binding written in the emitted text; `None` where the language has no place for it and the engine sets it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emitted_binding: Option<u32>,
    /// What is bound.
    pub kind: BindingKind,
}

/// Writes the files of one target.
pub fn emit(module: &Module, target: Target) -> Result<Vec<EmittedFile>> {
    match target {
        Target::Wgsl => wgsl::emit(module),
        Target::Glsl450 => glsl::emit_450(module),
        Target::GlslEs300 => glsl::emit_es300(module),
        Target::Spirv => spirv::emit(module),
    }
}

/// See the module's documentation for the reason.
const UNCHECKED: BoundsCheckPolicies = BoundsCheckPolicies {
    index: BoundsCheckPolicy::Unchecked,
    buffer: BoundsCheckPolicy::Unchecked,
    image_load: BoundsCheckPolicy::Unchecked,
    binding_array: BoundsCheckPolicy::Unchecked,
};

/// An entry point on its own: overrides resolved, everything else removed.
struct Single {
    name: String,
    stage: Stage,
    ir: naga::Module,
    info: naga::valid::ModuleInfo,
}

/// The entry points of a module, each on its own.
fn singles(module: &Module, target: Target) -> Result<Vec<Single>> {
    let single = |(name, stage): (&str, Stage)| {
        let constants = naga::back::PipelineConstants::default();
        let entry = Some((stage.to_naga(), name));
        let (ir, info) = naga::back::pipeline_constants::process_overrides(
            module.ir(),
            module.info(),
            entry,
            &constants,
        )
        .map_err(|error| failure(module, target, error))?;
        Ok(Single { name: name.to_owned(), stage, ir: ir.into_owned(), info: info.into_owned() })
    };
    module.entry_points().map(single).collect()
}

/// `diffraction[.ENTRY].SUFFIX`; the entry is left out for `vert` and `map`.
fn file_name(entry: &str, suffix: &str) -> String {
    match entry {
        MAIN_VERTEX | MAIN_FRAGMENT => format!("diffraction.{suffix}"),
        other => format!("diffraction.{other}.{suffix}"),
    }
}

/// The bound resources of a module, named as in the templates.
fn bindings(ir: &naga::Module) -> Vec<(naga::Handle<naga::GlobalVariable>, BindingName)> {
    let globals = ir.global_variables.iter();
    let bound = globals.filter_map(|(handle, global)| {
        let place = global.binding?;
        let name = global.name.clone().unwrap_or_default();
        let kind = match (global.space, &ir.types[global.ty].inner) {
            (AddressSpace::Uniform, _) => BindingKind::UniformBlock,
            (_, TypeInner::Sampler { .. }) => BindingKind::Sampler,
            _ => BindingKind::Texture,
        };
        let binding = BindingName {
            source_name: name.clone(),
            emitted_name: name,
            member_name: None,
            group: place.group,
            binding: place.binding,
            emitted_binding: Some(place.binding),
            kind,
        };
        Some((handle, binding))
    });
    bound.collect()
}

fn failure(module: &Module, target: Target, cause: impl fmt::Display) -> Error {
    let target = match target {
        Target::Wgsl => "wgsl",
        Target::Glsl450 => "glsl450",
        Target::GlslEs300 => "glsl-es300",
        Target::Spirv => "spirv",
    };
    Error::new(error::Stage::Shader, format_args!("{}: {target}", module.name()), cause)
}
