//! Runs the specialised WGSL on a driver, through wgpu.

use std::borrow::Cow;
use std::ops::Range;

use diffraction_shaders::error::Result;
use diffraction_shaders::runner::Placement;
use diffraction_shaders::shader::module::Module;
use diffraction_shaders::tables::{SAMPLER, Table, TexelFormat};

use super::driver::{BoundTable, Driver, DriverRunner, Prepared, Rows};
use super::gpu::{Gpu, Pipeline, Program, Shader, Texture, TextureFormat, TextureLayout, Uniform};

/// A variant's shader on one adapter.
pub type ShaderRunner<'a> = DriverRunner<'a, Gpu>;

impl<'a> ShaderRunner<'a> {
    /// Computes the tables. Nothing is compiled yet.
    pub fn new(placement: Placement<'a>, gpu: Gpu) -> Result<ShaderRunner<'a>> {
        Ok(DriverRunner::with(Prepared::new(placement)?, gpu))
    }
}

impl Driver for Gpu {
    type Pipeline = Pipeline;

    fn route(&self) -> String {
        let info = self.info();
        format!("{}:{}", info.backend, info.name)
    }

    fn pipeline(
        &self,
        module: &Module,
        entry: &str,
        tables: &[BoundTable<'_>],
    ) -> Result<Pipeline> {
        self.program(&Program {
            name: module.name(),
            shader: Shader::Wgsl(module.text()),
            vertex_entry: "vert",
            fragment_entry: entry,
            textures: tables.iter().map(|&(binding, table)| texture(table, binding)).collect(),
            uniform: Some(Uniform { binding: 0, size: size_of::<[f32; 8]>() as u32 }),
        })
    }
}

impl Rows for Pipeline {
    fn rows(&self, size: [u32; 2], params: &[f32; 8], band: Range<u32>) -> Result<Vec<[f32; 4]>> {
        Pipeline::rows(self, size, bytemuck::bytes_of(params), band)
    }
}

/// A table as a texture for wgpu.
pub fn texture(table: &Table, binding: u32) -> Texture<'static> {
    Texture {
        binding,
        layout: if table.layers == 0 { TextureLayout::D2 } else { TextureLayout::D2Array },
        format: match table.format {
            TexelFormat::Rg16Float => TextureFormat::Rg16Float,
            TexelFormat::Rgba16Float => TextureFormat::Rgba16Float,
            TexelFormat::Rg32Float => TextureFormat::Rg32Float,
            TexelFormat::Rgba32Float => TextureFormat::Rgba32Float,
            TexelFormat::Rgb9e5Ufloat => TextureFormat::Rgb9e5Ufloat,
        },
        width: table.width as u32,
        height: table.height as u32,
        layers: table.layers.max(1) as u32,
        sampler: table.filtered.then_some(SAMPLER),
        bytes: Cow::Owned(table.bytes()),
    }
}
