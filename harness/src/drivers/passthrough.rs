//! Emitted SPIR-V on Vulkan exactly as emitted, and emitted HLSL by way of glslang: the routes `spirv` and `hlsl`.
//!
//! * No adapter of Vulkan is special: lavapipe, SwiftShader, a graphics card.
//! * wgpu changes nothing of the shaders: neither bindings nor clip space, and it adds no run-time checks.
//! * HLSL is compiled entry point by entry point by `glslangValidator`, which makes registers bindings number by number.
//! * Wrong words can bring a driver down. So every module is looked through, and shown to `spirv-val` where that is installed,
//!   before the driver sees it.

mod compile;

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::plan::Target;
use diffraction_shaders::shader::emit::{BindingKind, EmittedFile, emit};
use diffraction_shaders::shader::module::{Module, Stage};

use crate::process::{GLSLANG, GLSLANG_PACKAGE, on_path};

use super::driver::{BoundTable, Driver, DriverRunner, PARAMS};
use super::gpu::{Backend, Gpu, Pipeline, Program, Shader, Texture, Uniform};
use super::shader;
use super::stages::stages;

/// A variant's emitted SPIR-V or HLSL on one adapter.
pub type PassthroughRunner<'a> = DriverRunner<'a, Passthrough>;

/// A language of emitted files that reaches Vulkan without wgpu's translation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Language {
    /// The emitted modules.
    Spirv,
    /// The emitted text, compiled by glslang.
    Hlsl,
}

impl Language {
    /// Both of them.
    pub const ALL: [Language; 2] = [Language::Spirv, Language::Hlsl];

    /// The target whose files these are.
    pub fn target(self) -> Target {
        match self {
            Language::Spirv => Target::Spirv,
            Language::Hlsl => Target::Hlsl,
        }
    }
}

impl fmt::Display for Language {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.target().as_str())
    }
}

/// An adapter of Vulkan that runs one language.
#[derive(Clone, Debug)]
pub struct Passthrough {
    gpu: Gpu,
    language: Language,
    /// glslang, where the language needs it.
    compiler: Option<PathBuf>,
}

impl Passthrough {
    /// Opens the best adapter of Vulkan whose name or driver contains `adapter`, where given, as [`Gpu::open`] does.
    pub fn open(language: Language, adapter: Option<&str>) -> Result<Passthrough> {
        // of two things that are missing, the one that is easier to install
        compiler(language)?;
        Passthrough::with(language, Gpu::open(Backend::Vulkan, adapter)?)
    }

    /// Runs a language on an adapter that is open already.
    pub fn with(language: Language, gpu: Gpu) -> Result<Passthrough> {
        Ok(Passthrough { gpu, language, compiler: compiler(language)? })
    }

    /// The language.
    pub fn language(&self) -> Language {
        self.language
    }

    /// The adapter.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Compiles the fragment entry point `entry` of emitted files, after their only vertex entry point, and uploads the
    /// tables; `name` is the variant's, for errors. Bindings are those that were reported with the files.
    pub fn compile(
        &self,
        name: &str,
        files: &[EmittedFile],
        entry: &str,
        tables: &[BoundTable<'_>],
    ) -> Result<Pipeline> {
        let [vertex, fragment] = stages(name, files, entry)?;
        let mut textures: Vec<Texture<'_>> = Vec::new();
        let mut uniform = None;
        for binding in vertex.0.bindings.iter().chain(&fragment.0.bindings) {
            let place = binding.emitted_binding.unwrap_or(binding.binding);
            let table = tables.iter().find(|(at, _)| *at == binding.binding);
            match (binding.kind, table) {
                (BindingKind::UniformBlock, _) if binding.binding == PARAMS => {
                    uniform = Some(Uniform { binding: place, size: size_of::<[f32; 8]>() as u32 });
                }
                // a file of several entry points names the tables of all; what this one lacks is found in its words
                (BindingKind::Texture, Some(&(_, table)))
                    if textures.iter().all(|texture| texture.binding != place) =>
                {
                    textures.push(shader::texture(table, place));
                }
                // comes with the textures that it reads
                _ => {}
            }
        }
        let words = |file, stage| compile::words(self.compiler.as_deref(), name, file, stage);
        let vertex_words = words(vertex, Stage::Vertex)?;
        let fragment_words = words(fragment, Stage::Fragment)?;
        self.gpu.program(&Program {
            name,
            shader: Shader::Spirv { vertex: &vertex_words, fragment: &fragment_words },
            vertex_entry: vertex.1,
            fragment_entry: fragment.1,
            textures,
            // every picture comes with its parameters
            uniform: uniform.or(Some(Uniform { binding: 0, size: size_of::<[f32; 8]>() as u32 })),
        })
    }
}

impl Driver for Passthrough {
    type Pipeline = Pipeline;

    fn route(&self) -> String {
        format!("{}:{}", self.language, self.gpu.info().name)
    }

    fn pipeline(
        &self,
        module: &Module,
        entry: &str,
        tables: &[BoundTable<'_>],
    ) -> Result<Pipeline> {
        let files = emit(module, self.language.target())?;
        self.compile(module.name(), &files, entry, tables)
    }

    fn rows(
        &self,
        pipeline: &Pipeline,
        size: [u32; 2],
        params: &[f32; 8],
        band: Range<u32>,
    ) -> Result<Vec<[f32; 4]>> {
        self.gpu.rows(pipeline, size, params, band)
    }
}

/// The compiler that a language needs.
fn compiler(language: Language) -> Result<Option<PathBuf>> {
    if language == Language::Spirv {
        return Ok(None);
    }
    on_path(GLSLANG).map(Some).ok_or_else(|| {
        let cause = format!("{GLSLANG} is not installed, which turns HLSL into SPIR-V");
        Error::new(language, cause)
            .remedy(format!("apt-get install {GLSLANG_PACKAGE}, or take the runner spirv"))
    })
}
