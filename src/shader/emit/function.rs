//! Function forms: the functions that a shader offers and everything that they call, without entry points and bindings.
//! The first function stands first in `.fn.wgsl`; the others are optional.
//!
//! - `.fn.wgsl` is the specialised text with its comments. Textures and the sampler are parameters after the
//!   directions, and are passed on to every function that reads them, since node systems such as that of three.js do
//!   not support global names. The text begins with `fn diffraction(`, as such systems require. The comment that
//!   describes it is at the beginning of the body.
//! - `.fn.glsl` declares its textures, combined with their samplers, as uniforms with their names in the templates. It
//!   has no `#version`, no precision statement and no `main`, and is valid after those of GLSL ES 3.00 and of GLSL
//!   4.50.
//! - A function that the host defines, such as `environment_radiance`, is only called; GLSL and HLSL declare it.
//! - `.fn.hlsl` declares its textures and the sampler as globals with their names in the templates, without registers.

mod core;
mod wgsl;

use crate::error::Result;
use crate::plan::Target;
use crate::shader::module::Module;

use super::{EmittedFile, Function, bindings, failure, glsl, head, hlsl};

use self::core::Core;

/// The function form that belongs to a target. `None` for targets whose engines accept only whole shaders.
pub fn emit(module: &Module, target: Target) -> Result<Option<EmittedFile>> {
    let fail = |cause: String| failure(module, target, format!("function form: {cause}"));
    let core = || core::extract(module, module.functions()).map_err(fail);
    let mut sampler_names = glsl::SamplerTextures::new();
    let (language, core, text) = match target {
        Target::Wgsl => {
            let core = core()?;
            let text = wgsl::write(module, &core);
            ("wgsl", core, text)
        }
        Target::Glsl450 | Target::GlslEs300 => {
            let core = core()?;
            let (text, names) = glsl_text(module, &core).map_err(fail)?;
            sampler_names = names;
            ("glsl", core, Ok(text))
        }
        Target::Hlsl => {
            let core = core()?;
            let text = hlsl_text(module, &core);
            ("hlsl", core, text)
        }
        Target::Spirv | Target::Msl => return Ok(None),
    };
    let text = text.map_err(fail)?;
    let functions = core.names.iter().map(|name| {
        let signature =
            signature(&text, name).ok_or(format!("`{name}` is missing in the emitted text"))?;
        Ok(Function { name: name.clone(), signature })
    });
    let functions: Result<_, String> = functions.collect();
    let read = bindings(&core.bound).into_iter().map(|(handle, mut binding)| {
        binding.emitted_binding = None;
        if let Some(texture) = sampler_names.get(&handle) {
            binding.emitted_name.clone_from(texture);
        }
        binding
    });
    Ok(Some(EmittedFile {
        name: format!("diffraction.fn.{language}"),
        target,
        bindings: read.collect(),
        functions: functions.map_err(fail)?,
        bytes: text.into_bytes(),
        entry_points: Vec::new(),
    }))
}

/// The text that naga writes for GLSL ES 3.00, without `#version`, precision statements and `main`. Desktop GLSL
/// accepts and ignores its precision qualifiers.
fn glsl_text(module: &Module, core: &Core) -> Result<(String, glsl::SamplerTextures), String> {
    let (whole, names) = glsl::write_unbound(&core.unbound, &core.info, core::SHELL)?;
    let mut kept = vec![head::bare(module), String::new()];
    let mut in_main = false;
    for line in whole.lines() {
        in_main |= line.starts_with("void main()");
        let framing = line.starts_with("#version") || line.starts_with("precision ");
        let twice_blank = line.is_empty() && kept.last().is_none_or(String::is_empty);
        if !(in_main || framing || twice_blank) {
            kept.push(line.to_owned());
        }
        in_main &= line != "}";
    }
    let text = kept.join("\n").trim_end().to_owned() + "\n";
    Ok((declared_only(&text, core)?, names))
}

fn hlsl_text(module: &Module, core: &Core) -> Result<String, String> {
    let (ir, info) = core.without_shell()?;
    declared_only(&hlsl::with_head(module, &hlsl::write_unbound(&ir, &info)?), core)
}

/// The text with declarations in place of the functions that the host defines.
fn declared_only(text: &str, core: &Core) -> Result<String, String> {
    let mut out = text.to_owned();
    for host in &core.hosts {
        let line = signature(&out, host).ok_or(format!("`{host}` is missing in the text"))?;
        let start = out.find(&line).unwrap_or_default();
        let end = out[start..].find("\n}").ok_or(format!("`{host}` has no end"))? + start + 2;
        out.replace_range(
            start..end,
            &format!("// Radiance of the surroundings: the host defines it.\n{line};"),
        );
    }
    Ok(out)
}

/// The declaration of a function: its line in the text up to the body.
fn signature(text: &str, name: &str) -> Option<String> {
    let declares = |line: &&str| {
        let before = line.split_once(&format!("{name}(")).map(|(before, _)| before);
        before.is_some_and(|before| {
            !before.is_empty() && before.ends_with(' ') && !before.starts_with([' ', '/'])
        })
    };
    let line = text.lines().find(declares)?;
    Some(line.trim_end().trim_end_matches('{').trim_end().to_owned())
}
