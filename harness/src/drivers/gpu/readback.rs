//! Pictures of float texels and other buffers, from a device back to memory.

use std::ops::Range;
use std::sync::mpsc;

use diffraction_shaders::error::{Error, Result};
use half::f16;

use super::guard::Shared;

/// Submits what is recorded and returns the rows `band` of an `Rgba16Float` or `Rgba32Float` texture, `[row][column]`.
pub(super) fn read_rows(
    shared: &Shared,
    name: &str,
    mut encoder: wgpu::CommandEncoder,
    texture: &wgpu::Texture,
    band: Range<u32>,
) -> Result<Vec<[f32; 4]>> {
    let wide = texture.format() == wgpu::TextureFormat::Rgba32Float;
    let texel = if wide { 16 } else { 8 };
    let (width, rows) = (texture.width(), band.end - band.start);
    let stride = row_bytes(width, texel);
    let buffer = shared.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("rows"),
        size: u64::from(stride) * u64::from(rows),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(stride),
        rows_per_image: None,
    };
    let origin = wgpu::Origin3d { x: 0, y: band.start, z: 0 };
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 },
    );
    let submission = shared.queue.submit([encoder.finish()]);
    read_buffer(shared, name, "the picture", (&buffer, &submission), |bytes| {
        let mut pixels = Vec::with_capacity(width as usize * rows as usize);
        for row in bytes.chunks_exact(stride as usize) {
            let texels = row[..(width * texel) as usize].chunks_exact(texel as usize);
            pixels.extend(texels.map(|bytes| {
                match wide {
                    true => bytemuck::pod_read_unaligned(bytes),
                    false => bytemuck::pod_read_unaligned::<[u16; 4]>(bytes)
                        .map(|b| f16::from_bits(b).to_f32()),
                }
            }));
        }
        pixels
    })
}

/// Hands the bytes of a buffer to `read` when its submission is done; `what` names them in errors.
pub(super) fn read_buffer<T>(
    shared: &Shared,
    name: &str,
    what: &str,
    (buffer, submission): (&wgpu::Buffer, &wgpu::SubmissionIndex),
    read: impl FnOnce(&[u8]) -> T,
) -> Result<T> {
    let (sender, receiver) = mpsc::channel();
    let slice = buffer.slice(..);
    slice.map_async(wgpu::MapMode::Read, move |outcome| {
        // the receiver lives longer than the mapping, or the result is not needed
        let _ = sender.send(outcome);
    });
    let unread = || Error::new(name, format!("{what} cannot be read back"));
    let outcome = loop {
        shared.wait(name, submission)?;
        match receiver.try_recv() {
            Ok(outcome) => break outcome,
            Err(mpsc::TryRecvError::Empty) => {}
            Err(mpsc::TryRecvError::Disconnected) => return Err(unread()),
        }
    };
    outcome.map_err(|e| unread().source(e))?;
    let view = slice.get_mapped_range().map_err(|e| unread().source(e))?;
    Ok(read(&view))
}

/// Bytes of a row in the buffer that it is read back through.
pub(super) fn row_bytes(width: u32, texel: u32) -> u32 {
    (width * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}
