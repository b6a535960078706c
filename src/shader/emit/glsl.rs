//! GLSL 4.50 and GLSL ES 3.00, one file per entry point. The entry point is called `main`.
//!
//! In ES all precisions are `highp`: naga writes this for float, int and every sampler.

use std::collections::BTreeMap;

use naga::back::glsl::{self, ReflectionInfo, Version};

use crate::error::Result;
use crate::plan::Target;
use crate::shader::module::{Module, Stage};

use super::{
    BindingKind, BindingName, EmittedFile, EntryPoint, Single, UNCHECKED, bindings, failure,
    file_name, head, singles,
};

/// Desktop GLSL. The text contains bindings: binding `b` of group 0 is texture unit or uniform block `b`.
pub fn emit_450(module: &Module) -> Result<Vec<EmittedFile>> {
    emit(module, Target::Glsl450, Version::Desktop(450), ["vert.glsl", "frag.glsl"])
}

/// GLSL for WebGL2. The language cannot express bindings; the engine sets them by name.
pub fn emit_es300(module: &Module) -> Result<Vec<EmittedFile>> {
    let version = Version::Embedded { version: 300, is_webgl: true };
    emit(module, Target::GlslEs300, version, ["es300.vert", "es300.frag"])
}

fn emit(
    module: &Module,
    target: Target,
    version: Version,
    [vertex, fragment]: [&str; 2],
) -> Result<Vec<EmittedFile>> {
    let mut files = Vec::new();
    let head = head::bare(module);
    for single in singles(module, target)? {
        let (text, bindings) =
            write(&single, version).map_err(|error| failure(module, target, error))?;
        let text = with_head(&head, &text);
        let suffix = match single.stage {
            Stage::Vertex => vertex,
            Stage::Fragment => fragment,
        };
        files.push(EmittedFile {
            name: file_name(&single.name, suffix),
            target,
            bytes: text.into_bytes(),
            entry_points: vec![EntryPoint {
                stage: single.stage,
                source_name: single.name,
                emitted_name: "main".to_owned(),
            }],
            bindings,
            functions: Vec::new(),
        });
    }
    Ok(files)
}

/// Text and names of one entry point.
fn write(single: &Single, version: Version) -> Result<(String, Vec<BindingName>), glsl::Error> {
    let explicit = version.supports_explicit_locations();
    let mut binding_map = glsl::BindingMap::new();
    for (_, global) in single.ir.global_variables.iter().filter(|_| explicit) {
        if let Some((place, unit)) = global.binding.and_then(|b| Some((b, unit(b)?))) {
            binding_map.insert(place, unit);
        }
    }
    let options = glsl::Options {
        version,
        // ADJUST_COORDINATE_SPACE is not set, so clip space stays as written
        writer_flags: glsl::WriterFlags::empty(),
        binding_map,
        zero_initialize_workgroup_memory: false,
    };
    let pipeline = glsl::PipelineOptions {
        shader_stage: single.stage.to_naga(),
        entry_point: single.name.clone(),
        multiview: None,
    };
    let mut text = String::new();
    let reflection =
        glsl::Writer::new(&mut text, &single.ir, &single.info, &options, &pipeline, UNCHECKED)?
            .write()?;
    let named = bindings(&single.ir).into_iter().map(|(handle, mut binding)| {
        rename(&mut binding, handle, single.stage, &reflection);
        let place = naga::ResourceBinding { group: binding.group, binding: binding.binding };
        let unit = options.binding_map.get(&place).map(|unit| u32::from(*unit));
        // a sampler shares the unit of its texture
        binding.emitted_binding = unit.filter(|_| binding.kind != BindingKind::Sampler);
        binding
    });
    let named = named.collect();
    Ok((text, named))
}

/// For every sampler, the name of a texture that it is combined with.
pub type SamplerTextures = BTreeMap<naga::Handle<naga::GlobalVariable>, String>;

/// Text in GLSL ES 3.00 of a module without bindings whose entry point is a fragment shader. Also returns, for every
/// sampler, the texture that it is combined with.
pub fn write_unbound(
    ir: &naga::Module,
    info: &naga::valid::ModuleInfo,
    entry: &str,
) -> Result<(String, SamplerTextures), String> {
    let options = glsl::Options {
        version: Version::Embedded { version: 300, is_webgl: true },
        writer_flags: glsl::WriterFlags::empty(),
        binding_map: glsl::BindingMap::new(),
        zero_initialize_workgroup_memory: false,
    };
    let pipeline = glsl::PipelineOptions {
        shader_stage: naga::ShaderStage::Fragment,
        entry_point: entry.to_owned(),
        multiview: None,
    };
    let mut text = String::new();
    let reflection = glsl::Writer::new(&mut text, ir, info, &options, &pipeline, UNCHECKED)
        .and_then(|mut writer| writer.write())
        .map_err(|error| error.to_string())?;
    // a sampler may be combined with several textures; the first name in alphabetical order is used
    let names: BTreeMap<&String, _> = reflection.texture_mapping.iter().collect();
    let pairs = names.iter().rev().filter_map(|(name, m)| Some((m.sampler?, (*name).clone())));
    Ok((text, pairs.collect()))
}

/// Unit of a binding. GLSL does not have groups, so only bindings of group 0 have a unit.
fn unit(place: naga::ResourceBinding) -> Option<u8> {
    if place.group == 0 { u8::try_from(place.binding).ok() } else { None }
}

/// Sets the emitted names, as naga reports them.
fn rename(
    binding: &mut BindingName,
    handle: naga::Handle<naga::GlobalVariable>,
    stage: Stage,
    reflection: &ReflectionInfo,
) {
    let of_texture = |(name, mapping): (&String, &glsl::TextureMapping)| {
        let found = mapping.texture == handle || mapping.sampler == Some(handle);
        found.then(|| name.clone())
    };
    match binding.kind {
        BindingKind::UniformBlock => {
            if let Some(block) = reflection.uniforms.get(&handle) {
                binding.emitted_name.clone_from(block);
                let stage = match stage {
                    Stage::Vertex => "vs",
                    Stage::Fragment => "fs",
                };
                binding.member_name =
                    Some(format!("_group_{}_binding_{}_{stage}", binding.group, binding.binding));
            }
        }
        BindingKind::Texture | BindingKind::Sampler => {
            // a sampler may be combined with several textures; the first name in alphabetical order is used
            let names = reflection.texture_mapping.iter().filter_map(of_texture);
            if let Some(name) = names.min() {
                binding.emitted_name = name;
            }
        }
    }
}

/// The comment goes below `#version`, because GLSL ES requires `#version` first.
fn with_head(head: &str, text: &str) -> String {
    let (version, rest) = text.split_once('\n').unwrap_or((text, ""));
    format!("{version}\n{head}\n\n{}\n", rest.trim())
}
