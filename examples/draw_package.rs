//! Draws the BRDF map of a package's shader with plain wgpu: all that an engine has to do, and nothing of this crate.
//!
//!     cargo run --release --features gpu --example draw_package -- [FOLDER] [PICTURE.png]

use std::{error::Error, fs, path::Path};

use wgpu::util::DeviceExt;
use wgpu::*;

#[allow(dead_code, reason = "an example does not need everything")]
mod bindings {
    include!("../generated/shaders/blazed/full-taylor-t19/bindings.rs");
}
use bindings::{PARAMS_BINDING, Params, SURFACE, TABLES, VARIANT};

const FOLDER: &str = "generated/shaders/blazed/full-taylor-t19";
const SIZE: u32 = 256;
const FORMAT: TextureFormat = TextureFormat::Rgba32Float;

fn main() -> Result<(), Box<dyn Error>> {
    // the package
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or(FOLDER.to_owned());
    let read = |file: &str| fs::read(Path::new(&folder).join(file));
    let manifest: serde_json::Value = serde_json::from_slice(&read("manifest.json")?)?;
    if manifest["variant"] != VARIANT || manifest["surface"] != SURFACE {
        return Err(format!("{folder} is not what {FOLDER}/bindings.rs describes").into());
    }
    let text = manifest["targets"]["wgsl"][0]["file"].as_str().ok_or("the package has no WGSL")?;
    let source = ShaderSource::Wgsl(String::from_utf8(read(text)?)?.into());

    // the pipeline; wgpu finds the layout in the shader
    let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
    let module = &device.create_shader_module(ShaderModuleDescriptor { label: None, source });
    let compilation_options = PipelineCompilationOptions::default();
    let targets = &[Some(FORMAT.into())];
    let (vert, map) = (Some("vert"), Some("map"));
    let vertex = VertexState { module, entry_point: vert, compilation_options, buffers: &[] };
    let compilation_options = PipelineCompilationOptions::default();
    let fragment = FragmentState { module, entry_point: map, compilation_options, targets };
    let pipeline = device.create_render_pipeline(&RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex,
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(fragment),
        multiview_mask: None,
        cache: None,
    });

    // the tables, and light from 20° on the right
    let texture = |[width, height, depth_or_array_layers]: [u32; 3], usage| TextureDescriptor {
        label: None,
        size: Extent3d { width, height, depth_or_array_layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format: FORMAT,
        usage,
        view_formats: &[],
    };
    let (x, z) = 20_f32.to_radians().sin_cos();
    let params = Params { light: [x, 0.0, z, 0.0], size: [SIZE as f32, SIZE as f32, 0.0, 0.0] };
    let params = [params.light, params.size];
    let (contents, usage) = (bytemuck::cast_slice(&params), BufferUsages::UNIFORM);
    let uniform = util::BufferInitDescriptor { label: None, contents, usage };
    let uniform = device.create_buffer_init(&uniform);
    let mut views = Vec::new();
    for table in TABLES {
        assert_eq!(table.format, "rgba32float", "FORMAT says so");
        let size = [table.width, table.height, table.layers];
        let (size, order) = (texture(size, TextureUsages::TEXTURE_BINDING), Default::default());
        let data = device.create_texture_with_data(&queue, &size, order, &read(table.data)?);
        let dimension = Some(match table.dimension {
            "2d-array" => TextureViewDimension::D2Array,
            _ => TextureViewDimension::D2,
        });
        let view = TextureViewDescriptor { dimension, ..Default::default() };
        views.push((table.binding, data.create_view(&view)));
    }
    let bound = |(binding, view)| (binding, BindingResource::TextureView(view));
    let tables = views.iter().map(|(binding, view)| bound((*binding, view)));
    let entries: Vec<BindGroupEntry> = tables
        .chain([(PARAMS_BINDING, uniform.as_entire_binding())])
        .map(|(binding, resource)| BindGroupEntry { binding, resource })
        .collect();
    let (label, layout) = (None, &pipeline.get_bind_group_layout(0));
    let group = BindGroupDescriptor { label, layout, entries: &entries };
    let group = device.create_bind_group(&group);

    // the picture
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
    let target = device.create_texture(&texture([SIZE, SIZE, 1], usage));
    let view = &target.create_view(&Default::default());
    let (depth_slice, resolve_target) = (None, None);
    let ops = Operations::default();
    let mut encoder = device.create_command_encoder(&Default::default());
    let attachment = RenderPassColorAttachment { view, depth_slice, resolve_target, ops };
    let color_attachments = &[Some(attachment)];
    let pass = RenderPassDescriptor { color_attachments, ..Default::default() };
    let mut pass = encoder.begin_render_pass(&pass);
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..3, 0..1);
    drop(pass);
    let bytes = vec![0; 16 * (SIZE * SIZE) as usize];
    let usage = BufferUsages::COPY_DST | BufferUsages::MAP_READ;
    let buffer = util::BufferInitDescriptor { label: None, contents: &bytes, usage };
    let buffer = device.create_buffer_init(&buffer);
    let (offset, bytes_per_row) = (0, Some(16 * SIZE));
    let layout = TexelCopyBufferLayout { offset, bytes_per_row, rows_per_image: None };
    let copy = TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(target.as_image_copy(), copy, target.size());
    queue.submit([encoder.finish()]);
    buffer.map_async(MapMode::Read, .., |result| result.unwrap());
    device.poll(PollType::wait_indefinitely())?;
    let bytes = buffer.get_mapped_range(..)?;
    let pixels: Vec<[f32; 4]> = bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect();
    // the brightest tenth of a percent is white; square roots stand for the curve of sRGB
    let mut greens: Vec<f32> = pixels.iter().map(|pixel| pixel[1]).collect();
    greens.sort_by(f32::total_cmp);
    let white = greens[greens.len() - greens.len() / 1000];
    let encode = |v: f32| (255.0 * (v / white).clamp(0.0, 1.0).sqrt()) as u8;
    let picture = image::RgbaImage::from_fn(SIZE, SIZE, |x, y| {
        let [r, g, b, a] = pixels[(y * SIZE + x) as usize];
        image::Rgba([encode(r), encode(g), encode(b), (255.0 * a) as u8])
    });
    Ok(picture.save(arguments.next().unwrap_or("map.png".to_owned()))?)
}
