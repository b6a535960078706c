//! Evaluation of the specialised WGSL by a driver, through wgpu.

use std::borrow::Cow;
use std::cell::RefCell;
use std::ops::ControlFlow;

use glam::DVec3;

use crate::assemble;
use crate::diagnostic::Diagnostic;
use crate::error::{Error, Result, Stage};
use crate::frame::{Frame, view_direction};
use crate::optics::gain;
use crate::reference::Directions;
use crate::resolve::{Resolved, resolve};
use crate::spectrum::from_rgb;
use crate::tables::{Table, TexelFormat};
use crate::template::Sources;

use super::gpu::{Gpu, Pipeline, Program, Texture, TextureFormat, TextureLayout, Uniform};
use super::{Progress, Runner, Subject, has_wavelengths};

/// Bytes of the uniform block `Params`: light and size.
const UNIFORM_BYTES: u32 = 32;
/// Directions in a row of the probe's picture.
const PROBE_WIDTH: usize = 512;
/// Rows of a picture that are submitted at once, so that progress shows and an interrupt is heard.
const BAND_ROWS: u32 = 16;

/// A variant's shader on one adapter.
pub struct ShaderRunner<'a> {
    subject: Subject<'a>,
    gpu: Gpu,
    resolved: Resolved,
    tables: Vec<Table>,
    map: RefCell<Option<Pipeline>>,
}

impl<'a> ShaderRunner<'a> {
    /// Computes the tables and compiles nothing yet.
    pub fn new(subject: Subject<'a>, gpu: Gpu) -> Result<ShaderRunner<'a>> {
        let Subject { height, rotate_deg, variant } = subject;
        let resolved = resolve(variant, height)?;
        let tables = assemble::tables(variant, &resolved, height, rotate_deg)?;
        Ok(ShaderRunner { subject, gpu, resolved, tables, map: RefCell::new(None) })
    }

    /// Compiles an entry point with its tables; `directions` only for `probe`.
    fn pipeline(
        &self,
        entry: &str,
        tables: &[Table],
        directions: Option<Texture<'_>>,
    ) -> Result<Pipeline> {
        let Subject { rotate_deg, variant, .. } = self.subject;
        let nodes = assemble::node_count(tables);
        let defines = assemble::defines(variant, &self.resolved, rotate_deg, nodes);
        let module =
            assemble::shader(&Sources::builtin(), &variant.name, &defines).map_err(first)?;
        let mut textures: Vec<Texture<'_>> = tables.iter().map(texture).collect();
        textures.extend(directions);
        self.gpu.program(&Program {
            name: &variant.name,
            wgsl: module.text(),
            vertex_entry: "vert",
            fragment_entry: entry,
            textures,
            uniform: Some(Uniform { binding: 0, size: UNIFORM_BYTES }),
        })
    }

    /// Evaluates `probe` with any tables; directions in pictures of at most a megapixel.
    fn probe(
        &self,
        tables: &[Table],
        directions: &[Directions],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        let mut out = Vec::with_capacity(directions.len());
        for block in directions.chunks(PROBE_WIDTH * 1024) {
            let rows = block.len().div_ceil(PROBE_WIDTH);
            // rows 2k hold directions to the light, rows 2k + 1 those to the viewer; black below the horizon fills up
            let mut texels = vec![0.0_f32; 2 * rows * PROBE_WIDTH * 4];
            for (i, d) in block.iter().enumerate() {
                let at = |row: usize| (row * PROBE_WIDTH + i % PROBE_WIDTH) * 4;
                for (row, v) in [(2 * (i / PROBE_WIDTH), d.wi), (2 * (i / PROBE_WIDTH) + 1, d.wr)] {
                    texels[at(row)..at(row) + 3].copy_from_slice(&v.as_vec3().to_array());
                }
            }
            let directions = Texture {
                binding: 3,
                layout: TextureLayout::D2,
                format: TextureFormat::Rgba32Float,
                width: PROBE_WIDTH as u32,
                height: 2 * rows as u32,
                layers: 1,
                bytes: Cow::Owned(texels.iter().flat_map(|v| v.to_le_bytes()).collect()),
            };
            let pipeline = self.pipeline("probe", tables, Some(directions))?;
            let (width, height) = (PROBE_WIDTH as u32, rows as u32);
            let picture =
                bands(&pipeline, width, height, &uniform(DVec3::Z, width, height), progress)?;
            out.extend(picture.iter().take(block.len()).map(|c| [c[0], c[1], c[2]].map(f64::from)));
        }
        Ok(out)
    }
}

impl Runner for ShaderRunner<'_> {
    fn route(&self) -> String {
        let info = self.gpu.info();
        format!("{}:{}", info.backend, info.name)
    }

    fn tristimulus(
        &self,
        directions: &[Directions],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        self.probe(&self.tables, directions, progress)
    }

    /// The shader with a single wavelength of weight 1 returns `C·|P|²`; the gain is taken off again in f64.
    fn response(&self, directions: &[Directions], lambda_nm: f64) -> Result<Vec<f64>> {
        let Subject { rotate_deg, variant, .. } = self.subject;
        has_wavelengths(variant)?;
        let tables =
            assemble::single_wavelength(&self.tables, &self.resolved, lambda_nm, rotate_deg);
        let rho = self.probe(&tables, directions, &|_| ())?;
        let gains = directions.iter().map(|d| gain(d.wi, d.wr, &variant.optics));
        Ok(rho
            .iter()
            .zip(gains)
            .map(|(rho, gain)| if gain > 0.0 { rho[0] / gain } else { 0.0 })
            .collect())
    }

    /// The `map` entry point; its linear RGB is taken back to tristimulus values.
    fn map(&self, light: DVec3, size: usize, progress: Progress<'_>) -> Result<Frame> {
        let mut cached = self.map.borrow_mut();
        let pipeline = match cached.take() {
            Some(pipeline) => pipeline,
            None => self.pipeline("map", &self.tables, None)?,
        };
        let pixels = size as u32;
        let picture = bands(&pipeline, pixels, pixels, &uniform(light, pixels, pixels), progress);
        *cached = Some(pipeline);
        let colour = self.subject.variant.optics.colour;
        let xyz = |(i, c): (usize, &[f32; 4])| {
            view_direction(i % size, i / size, size)
                .map(|_| from_rgb([c[0], c[1], c[2]].map(f64::from), colour))
        };
        Ok(Frame { size, xyz: picture?.iter().enumerate().map(xyz).collect() })
    }
}

fn bands(
    pipeline: &Pipeline,
    width: u32,
    height: u32,
    uniform: &[u8],
    progress: Progress<'_>,
) -> Result<Vec<[f32; 4]>> {
    let mut before = 0;
    pipeline.render_bands(width, height, uniform, BAND_ROWS, |done, _| {
        progress((done - before) as usize * width as usize);
        before = done;
        ControlFlow::Continue(())
    })
}

fn uniform(light: DVec3, width: u32, height: u32) -> Vec<u8> {
    let light = light.as_vec3();
    let values = [light.x, light.y, light.z, 0.0, width as f32, height as f32, 0.0, 0.0];
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn texture(table: &Table) -> Texture<'static> {
    Texture {
        binding: table.binding,
        layout: if table.layers == 0 { TextureLayout::D2 } else { TextureLayout::D2Array },
        format: match table.format {
            TexelFormat::Rg16Float => TextureFormat::Rg16Float,
            TexelFormat::Rgba16Float => TextureFormat::Rgba16Float,
            TexelFormat::Rg32Float => TextureFormat::Rg32Float,
            TexelFormat::Rgba32Float => TextureFormat::Rgba32Float,
        },
        width: table.width as u32,
        height: table.height as u32,
        layers: table.layers.max(1) as u32,
        bytes: Cow::Owned(table.bytes()),
    }
}

/// The first diagnostic of a shader that does not compile; `generate` shows all of them in their places.
fn first(diagnostics: Vec<Diagnostic>) -> Error {
    let message = diagnostics.first().map_or("does not compile", |d| d.message.as_str());
    Error::new(Stage::Shader, "shader", message)
        .remedy("cargo xtask generate shows every error with its place")
}
