//! Draws frames in bands and reads them back.

use std::{
    fmt,
    ops::{ControlFlow, Range},
    sync::{Arc, Mutex, mpsc},
};

use diffraction_shaders::error::{Error, Result};

use super::guard::{Shared, lock};

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
        self.render_bands(width, height, uniform, height, |_, _| ControlFlow::Continue(()))
    }

    /// Like [`render`](Self::render), in bands of at most `rows` rows, each a submission of its own.
    ///
    /// After each band `progress` gets the number of finished rows and their total. If it breaks, no further band is drawn and the
    /// result is an error that says so. The pixels do not depend on `rows`.
    pub fn render_bands(
        &self,
        width: u32,
        height: u32,
        uniform: &[u8],
        rows: u32,
        mut progress: impl FnMut(u32, u32) -> ControlFlow<()>,
    ) -> Result<Vec<[f32; 4]>> {
        self.check(width, height, uniform)?;
        // read back in pieces well below any max_buffer_size
        let max = ((64 << 20) / row_bytes(width)).max(1);
        let rows = rows.clamp(1, max);
        let target = self.target(width, height)?;
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        let mut done = 0;
        while done < height {
            let band = done..height.min(done + rows);
            done = band.end;
            self.shared.guarded(&self.name, || self.read(&target, uniform, band, &mut pixels))?;
            if progress(done, height).is_break() && done < height {
                return Err(Error::new(
                    &self.name,
                    format!("interrupted after {done} of {height} rows"),
                ));
            }
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

    /// Records the rows `band` of a frame.
    fn draw(&self, target: &Target, uniform: &[u8], band: Range<u32>) -> wgpu::CommandEncoder {
        let mut encoder = self.encoder(uniform);
        self.pass(&mut encoder, target, band, None);
        encoder
    }

    /// An empty recording. Uploads the bytes of the uniform block.
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

    /// Draws the rows `band` and appends them to `pixels`.
    fn read(
        &self,
        target: &Target,
        uniform: &[u8],
        band: Range<u32>,
        pixels: &mut Vec<[f32; 4]>,
    ) -> Result<()> {
        let (device, queue) = (&self.shared.device, &self.shared.queue);
        let rows = band.end - band.start;
        let stride = row_bytes(target.width);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("rows"),
            size: u64::from(stride) * u64::from(rows),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.draw(target, uniform, band.clone());
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                texture: &target.texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: band.start, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(stride),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { width: target.width, height: rows, depth_or_array_layers: 1 },
        );
        let submission = queue.submit([encoder.finish()]);
        let (sender, receiver) = mpsc::channel();
        let slice = buffer.slice(..);
        slice.map_async(wgpu::MapMode::Read, move |outcome| {
            // the receiver lives longer than the mapping, or the result is not needed
            let _ = sender.send(outcome);
        });
        let unread = || Error::new(&self.name, "the frame cannot be read back");
        let outcome = loop {
            self.shared.wait(&self.name, &submission)?;
            match receiver.try_recv() {
                Ok(outcome) => break outcome,
                Err(mpsc::TryRecvError::Empty) => {}
                Err(mpsc::TryRecvError::Disconnected) => return Err(unread()),
            }
        };
        outcome.map_err(|e| unread().source(e))?;
        let view = slice.get_mapped_range().map_err(|e| unread().source(e))?;
        for row in view.chunks_exact(stride as usize) {
            let texels = &row[..(target.width * PIXEL_BYTES) as usize];
            let texels = texels.chunks_exact(PIXEL_BYTES as usize);
            pixels.extend(texels.map(bytemuck::pod_read_unaligned::<[f32; 4]>));
        }
        Ok(())
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

/// Bytes of a row in the buffer for reading back.
fn row_bytes(width: u32) -> u32 {
    (width * PIXEL_BYTES).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}
