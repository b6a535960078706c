//! Draws frames in bands and reads them back.

use std::{
    fmt,
    ops::Range,
    sync::{Arc, Mutex},
};

use diffraction_shaders::error::{Error, Result};

use super::guard::{Shared, lock};
use super::readback::{read_rows, row_bytes};

/// The format of the render target.
pub(super) const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

const PIXEL_BYTES: u32 = 16;

/// A compiled program with its textures on the device.
pub struct Pipeline {
    pub(super) shared: Arc<Shared>,
    pub(super) name: String,
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    uniform: Option<(wgpu::Buffer, u32)>,
    /// The target of the last frame, kept for the next frame of that size.
    pub(super) kept: Mutex<Option<Target>>,
}

impl Pipeline {
    /// Draws one frame and returns its pixels, `[row][column]`, top row first.
    ///
    /// `uniform` holds the bytes of the uniform block; empty if the program has no uniform block.
    pub fn render(&self, width: u32, height: u32, uniform: &[u8]) -> Result<Vec<[f32; 4]>> {
        self.rows([width, height], uniform, 0..height)
    }

    /// The rows `band` of [`render`](Self::render)'s frame: nothing else is drawn, and the pixels are the same.
    pub fn rows(
        &self,
        [width, height]: [u32; 2],
        uniform: &[u8],
        band: Range<u32>,
    ) -> Result<Vec<[f32; 4]>> {
        self.check(width, height, uniform)?;
        let target = self.target(width, height)?;
        // what is read back at once: well below any max_buffer_size
        let most = ((64 << 20) / row_bytes(width, PIXEL_BYTES)).max(1);
        let mut pixels = Vec::with_capacity(width as usize * band.len());
        for top in band.clone().step_by(most as usize) {
            let part = top..band.end.min(top + most);
            pixels.extend(self.shared.guarded(&self.name, || self.read(&target, uniform, part))?);
        }
        *lock(&self.kept) = Some(target);
        Ok(pixels)
    }

    pub(super) fn new(
        shared: Arc<Shared>,
        name: &str,
        pipeline: wgpu::RenderPipeline,
        group: wgpu::BindGroup,
        uniform: Option<(wgpu::Buffer, u32)>,
    ) -> Pipeline {
        let name = name.to_owned();
        Pipeline { shared, name, pipeline, group, uniform, kept: Mutex::new(None) }
    }

    pub(super) fn check(&self, width: u32, height: u32, uniform: &[u8]) -> Result<()> {
        let fail = |cause: String| Err(Error::new(&self.name, cause));
        let side = self.shared.limits.max_texture_dimension_2d;
        if width == 0 || height == 0 {
            return fail(format!("a frame of {width} × {height} pixels is empty"));
        }
        if width > side || height > side {
            return fail(format!(
                "a frame of {width} × {height} pixels, but max_texture_dimension_2d is {side}"
            ));
        }
        let declared = self.uniform.as_ref().map_or(0, |(_, size)| *size);
        if uniform.len() != declared as usize {
            return fail(format!(
                "the uniform block has {declared} bytes, but got {}",
                uniform.len()
            ));
        }
        Ok(())
    }

    /// A target of this size: the kept one of the last frame, or a new one.
    pub(super) fn target(&self, width: u32, height: u32) -> Result<Target> {
        let kept = lock(&self.kept).take();
        if let Some(target) = kept.filter(|kept| kept.width == width && kept.height == height) {
            return Ok(target);
        }
        self.shared.guarded(&self.name, || {
            let texture = self.shared.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("frame"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: TARGET,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            });
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            Ok(Target { width, height, texture, view })
        })
    }

    /// An empty recording; hands over the bytes of the uniform block.
    pub(super) fn encoder(&self, uniform: &[u8]) -> wgpu::CommandEncoder {
        if let Some((buffer, _)) = &self.uniform {
            self.shared.queue.write_buffer(buffer, 0, uniform);
        }
        let descriptor = wgpu::CommandEncoderDescriptor { label: Some(&self.name) };
        self.shared.device.create_command_encoder(&descriptor)
    }

    /// Records a render pass over the rows `band` of a frame.
    pub(super) fn pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &Target,
        band: Range<u32>,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let load = match band.start {
            0 => wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
            _ => wgpu::LoadOp::Load,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&self.name),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
            })],
            timestamp_writes,
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.set_scissor_rect(0, band.start, target.width, band.end - band.start);
        pass.draw(0..3, 0..1);
    }

    /// Draws the rows `band` and reads them back.
    fn read(&self, target: &Target, uniform: &[u8], band: Range<u32>) -> Result<Vec<[f32; 4]>> {
        let mut encoder = self.encoder(uniform);
        self.pass(&mut encoder, target, band.clone(), None);
        read_rows(&self.shared, &self.name, encoder, &target.texture, band)
    }
}

impl fmt::Debug for Pipeline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pipeline")
            .field("name", &self.name)
            .field("adapter", &self.shared.info)
            .finish_non_exhaustive()
    }
}

pub(super) struct Target {
    width: u32,
    height: u32,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}
