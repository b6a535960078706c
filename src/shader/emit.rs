//! One function per target language.
//!
//! Common to all targets: clip space is as in the WGSL text (y up, depth 0 … 1) and is not rewritten, since the engine
//! provides the matrices. Loops get no artificial bounds. Overrides are resolved before a writer runs. Run-time bounds
//! checks are off: the templates keep every index and texel coordinate in range by construction, and checks in the
//! innermost loop would cost up to half of the speed. WGSL keeps the checks that its implementation adds.
//!
//! Every text except SPIR-V begins with the same comment: what the shader is, its inputs and output, and where bindings
//! and tolerances are described.
//!
//! In addition to whole shaders there are function forms, for engines that need a piece of text to paste or register. A
//! function form has the functions that the shader offers and everything that they call, without entry points, bindings
//! and uniform blocks. It is written with the targets of its language: `.fn.wgsl` with `wgsl`, `.fn.glsl` with
//! `glsl450` and with `glsl-es300` (one file, the same for both), `.fn.hlsl` with `hlsl`.

mod function;
mod glsl;
mod head;
mod hlsl;
mod msl;
mod spirv;
mod wgsl;

use std::fmt;

use naga::{
    AddressSpace, TypeInner,
    proc::{BoundsCheckPolicies, BoundsCheckPolicy},
};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::plan::Target;
use crate::shader::module::{Module, Stage};

/// The fragment entry point whose file names do not contain its name.
const MAIN_FRAGMENT: &str = "map";
const MAIN_VERTEX: &str = "vert";
/// The vertex entry point that belongs to the fragment entry point `mesh`. Both have `mesh` in their file names; in one
/// text their names must differ.
const MESH_VERTEX: &str = "mesh_vert";

/// One file of one target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EmittedFile {
    /// File name, without a folder.
    pub name: String,
    /// Its target.
    pub target: Target,
    /// Text in UTF-8, or the words of SPIR-V in little-endian order.
    pub bytes: Vec<u8>,
    /// Entry points in the file, in the order of the template text.
    pub entry_points: Vec<EntryPoint>,
    /// The resources that these entry points or functions read, in the order of the template text.
    pub bindings: Vec<BindingName>,
    /// Functions that a function form offers. Empty for whole shaders.
    pub functions: Vec<Function>,
}

impl EmittedFile {
    /// Names of the uniform blocks by which an engine finds them.
    pub fn uniform_blocks(&self) -> impl Iterator<Item = &str> {
        let blocks = self.bindings.iter().filter(|b| b.kind == BindingKind::UniformBlock);
        blocks.map(|block| block.emitted_name.as_str())
    }
}

/// An entry point of a shader.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct EntryPoint {
    /// Vertex or fragment.
    pub stage: Stage,
    /// Its name in the templates.
    pub source_name: String,
    /// Its name in the file.
    pub emitted_name: String,
}

/// A function that engine code can call.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Function {
    /// Name, the same in the templates and in the file.
    pub name: String,
    /// Declaration in the file.
    pub signature: String,
}

/// The kind of a binding.
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

/// The name of a resource in a target's file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct BindingName {
    /// Name of the variable in the templates.
    pub source_name: String,
    /// Name by which the graphics API finds it: the name of the uniform block or of the variable. For a sampler in GLSL
    /// it is the name of the texture that it is combined with.
    pub emitted_name: String,
    /// Name of the variable inside a GLSL uniform block.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub member_name: Option<String>,
    /// Bind group or descriptor set in the templates.
    pub group: u32,
    /// Binding in the templates.
    pub binding: u32,
    /// Binding written in the emitted text. In HLSL it is the number of register `b`, `t` or `s`, in Metal of the
    /// `buffer`, `texture` or `sampler` slot. `None` if the language cannot express it and the engine sets it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emitted_binding: Option<u32>,
    /// The kind of the binding.
    pub kind: BindingKind,
}

/// Writes the files of one target.
pub fn emit(module: &Module, target: Target) -> Result<Vec<EmittedFile>> {
    let mut files = match target {
        Target::Wgsl => wgsl::emit(module),
        Target::Glsl450 => glsl::emit_450(module),
        Target::GlslEs300 => glsl::emit_es300(module),
        Target::Spirv => spirv::emit(module),
        Target::Hlsl => hlsl::emit(module),
        Target::Msl => msl::emit(module),
    }?;
    files.extend(function::emit(module, target)?);
    Ok(files)
}

/// See the module's documentation for the reason.
const UNCHECKED: BoundsCheckPolicies = BoundsCheckPolicies {
    index: BoundsCheckPolicy::Unchecked,
    buffer: BoundsCheckPolicy::Unchecked,
    image_load: BoundsCheckPolicy::Unchecked,
    binding_array: BoundsCheckPolicy::Unchecked,
};

/// A module with a single entry point: overrides resolved, everything unused removed.
struct Single {
    name: String,
    stage: Stage,
    ir: naga::Module,
    info: naga::valid::ModuleInfo,
}

/// A module with its overrides resolved: all of it, or one entry point with what it needs.
fn resolved(
    module: &Module,
    target: Target,
    entry: Option<(Stage, &str)>,
) -> Result<(naga::Module, naga::valid::ModuleInfo)> {
    let (ir, info) = naga::back::pipeline_constants::process_overrides(
        module.ir(),
        module.info(),
        entry.map(|(stage, name)| (stage.to_naga(), name)),
        &naga::back::PipelineConstants::default(),
    )
    .map_err(|error| failure(module, target, error))?;
    Ok((ir.into_owned(), info.into_owned()))
}

/// The entry points of a module with the names in the emitted text. It is an error if the writer left one out.
fn entry_points(
    module: &Module,
    emitted: impl IntoIterator<Item = Result<String, String>>,
) -> Result<Vec<EntryPoint>, String> {
    let pairs = module.entry_points().zip(emitted);
    let named = pairs.map(|((name, stage), emitted)| {
        let emitted_name = emitted.map_err(|cause| format!("entry point `{name}`: {cause}"))?;
        Ok(EntryPoint { stage, source_name: name.to_owned(), emitted_name })
    });
    named.collect()
}

/// The entry points of a module, each in a module of its own.
fn singles(module: &Module, target: Target) -> Result<Vec<Single>> {
    let single = |(name, stage): (&str, Stage)| {
        let (ir, info) = resolved(module, target, Some((stage, name)))?;
        Ok(Single { name: name.to_owned(), stage, ir, info })
    };
    module.entry_points().map(single).collect()
}

/// `diffraction[.ENTRY].SUFFIX`. `ENTRY` is omitted for `vert` and `map`, and is `mesh` for `mesh_vert`.
fn file_name(entry: &str, suffix: &str) -> String {
    match entry {
        MAIN_VERTEX | MAIN_FRAGMENT => format!("diffraction.{suffix}"),
        MESH_VERTEX => format!("diffraction.mesh.{suffix}"),
        other => format!("diffraction.{other}.{suffix}"),
    }
}

/// The bound resources of a module, with their names in the templates.
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
    let subject = format!("{}: {}", module.name(), target.as_str());
    Error::new(subject, cause)
}
