//! Reads pictures of float texels back from a device.

use std::sync::mpsc;

use diffraction_shaders::error::{Error, Result};
use half::f16;

use super::guard::Shared;

/// The texels of an `Rgba16Float` or `Rgba32Float` texture, `[row][column]`.
pub(super) fn read_back(
    shared: &Shared,
    name: &str,
    texture: &wgpu::Texture,
) -> Result<Vec<[f32; 4]>> {
    let wide = texture.format() == wgpu::TextureFormat::Rgba32Float;
    let texel = if wide { 16 } else { 8 };
    let (width, height) = (texture.width(), texture.height());
    let stride = (width * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = shared.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("rows"),
        size: u64::from(stride) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = shared.device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(stride),
        rows_per_image: None,
    };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
    let submission = shared.queue.submit([encoder.finish()]);
    let (sender, receiver) = mpsc::channel();
    let slice = buffer.slice(..);
    slice.map_async(wgpu::MapMode::Read, move |outcome| {
        // the receiver lives longer than the mapping, or the result is not needed
        let _ = sender.send(outcome);
    });
    let unread = || Error::new(name, "the picture cannot be read back");
    let outcome = loop {
        shared.wait(name, &submission)?;
        match receiver.try_recv() {
            Ok(outcome) => break outcome,
            Err(mpsc::TryRecvError::Empty) => {}
            Err(mpsc::TryRecvError::Disconnected) => return Err(unread()),
        }
    };
    outcome.map_err(|e| unread().source(e))?;
    let view = slice.get_mapped_range().map_err(|e| unread().source(e))?;
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for row in view.chunks_exact(stride as usize) {
        let texels = row[..(width * texel) as usize].chunks_exact(texel as usize);
        pixels.extend(texels.map(|bytes| match wide {
            true => bytemuck::pod_read_unaligned(bytes),
            false => {
                bytemuck::pod_read_unaligned::<[u16; 4]>(bytes).map(|b| f16::from_bits(b).to_f32())
            }
        }));
    }
    Ok(pixels)
}
