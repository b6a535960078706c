//! The routes `spirv` and `hlsl`: emitted SPIR-V on Vulkan, unchanged, and emitted HLSL, compiled by glslang.
//!
//! * All adapters of Vulkan can run them: lavapipe, SwiftShader, a graphics card.
//! * wgpu does not change the shaders, neither bindings nor clip space, and adds no run-time checks.
//! * `glslangValidator` compiles HLSL entry point by entry point. It turns registers into bindings of the same number.
//! * Wrong words can crash a driver. So before the driver gets a module, its form is checked, and `spirv-val` checks it, if
//!   installed.

mod compile;

use std::fmt;
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

/// A language of emitted files that wgpu does not translate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Language {
    /// The emitted SPIR-V modules.
    Spirv,
    /// The emitted HLSL, compiled by glslang.
    Hlsl,
}

impl Language {
    /// Both languages.
    pub const ALL: [Language; 2] = [Language::Spirv, Language::Hlsl];

    /// The target whose files it runs.
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
    /// glslang, if the language needs it.
    compiler: Option<PathBuf>,
}

impl Passthrough {
    /// Opens the best adapter of Vulkan, whose name or driver contains `adapter` if given, like [`Gpu::open`].
    pub fn open(language: Language, adapter: Option<&str>) -> Result<Passthrough> {
        // if both are missing, report the one that is easier to install
        compiler(language)?;
        Passthrough::with(language, Gpu::open(Backend::Vulkan, adapter)?)
    }

    /// Runs a language on an open adapter.
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

    /// Compiles the fragment entry point `entry` of emitted files with their only vertex entry point, and uploads the tables.
    /// `name` is the variant's name, for errors. Bindings are those that were reported with the files.
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
                // a file lists the tables of all its entry points; which of them are missing is found in the words
                (BindingKind::Texture, Some(&(_, table)))
                    if textures.iter().all(|texture| texture.binding != place) =>
                {
                    textures.push(shader::texture(table, place));
                }
                // samplers come with their textures
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
            // every picture brings its parameters
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
}

/// The compiler that a language needs.
fn compiler(language: Language) -> Result<Option<PathBuf>> {
    if language == Language::Spirv {
        return Ok(None);
    }
    on_path(GLSLANG).map(Some).ok_or_else(|| {
        let cause = format!("{GLSLANG} is not installed, but HLSL needs it");
        Error::new(language, cause)
            .remedy(format!("apt-get install {GLSLANG_PACKAGE}, or use the runner spirv"))
    })
}
