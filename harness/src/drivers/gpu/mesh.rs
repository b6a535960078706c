//! Draws meshes: vertex buffers, a depth buffer, several samples per pixel, several pictures at once.

use std::borrow::Cow;
use std::sync::Arc;

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::variant::mesh::Vertex;

use super::guard::Shared;
use super::program::{Texture, dimension, layout_entry, linear, samplers, upload};
use super::readback::read_rows;
use crate::drivers::ColourMap;

/// Count of numbers in a vertex: position, normal, tangent, texture coordinates, angle.
pub const VERTEX_NUMBERS: usize = 13;
/// Format of the depth buffer.
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A mesh on the device.
pub struct MeshBuffers {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
}

/// A colour map with the bindings of its texture and its sampler.
#[derive(Clone, Copy, Debug)]
pub struct Colours<'a> {
    /// The picture.
    pub map: &'a ColourMap,
    /// Binding of the texture, filterable.
    pub binding: u32,
    /// Binding of the sampler: linear, repeating.
    pub sampler: u32,
}

/// One pass over a mesh.
pub struct MeshProgram<'a> {
    /// Name of the pass, for errors.
    pub name: &'a str,
    /// The WGSL with both entry points.
    pub wgsl: &'a str,
    /// The vertex entry point, which reads the vertices at locations 0 to 4.
    pub vertex_entry: &'a str,
    /// The fragment entry point, which returns one `vec4f` for each picture.
    pub fragment_entry: &'a str,
    /// The textures of group 0.
    pub textures: Vec<Texture<'a>>,
    /// Colours of the body, if the shader reads them.
    pub colours: Option<Colours<'a>>,
    /// Bindings and sizes in bytes of the uniform blocks. Each frame brings their content.
    pub uniforms: Vec<(u32, usize)>,
}

/// A compiled pass.
pub struct MeshPipeline {
    pub(super) pipeline: wgpu::RenderPipeline,
    pub(super) group: wgpu::BindGroup,
    pub(super) uniforms: Vec<wgpu::Buffer>,
}

/// The targets of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Targets {
    /// Number of pictures.
    pub pictures: usize,
    /// True: four samples per pixel in 16-bit floats. False: one sample in 32-bit floats.
    pub multisampled: bool,
}

impl Targets {
    pub(super) fn format(self) -> wgpu::TextureFormat {
        if self.multisampled {
            wgpu::TextureFormat::Rgba16Float
        } else {
            wgpu::TextureFormat::Rgba32Float
        }
    }

    fn samples(self) -> u32 {
        if self.multisampled { 4 } else { 1 }
    }
}

/// Uploads vertices and triangles in the given order.
pub(super) fn buffers(shared: &Shared, vertices: &[Vertex], triangles: &[[u32; 3]]) -> MeshBuffers {
    let numbers: Vec<f32> = vertices.iter().flat_map(numbers).collect();
    let buffer = |bytes: &[u8], usage| {
        let buffer = shared.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("mesh"),
            size: bytes.len() as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        shared.queue.write_buffer(&buffer, 0, bytes);
        buffer
    };
    MeshBuffers {
        vertices: buffer(bytemuck::cast_slice(&numbers), wgpu::BufferUsages::VERTEX),
        indices: buffer(bytemuck::cast_slice(triangles), wgpu::BufferUsages::INDEX),
        count: 3 * triangles.len() as u32,
    }
}

fn numbers(vertex: &Vertex) -> [f32; VERTEX_NUMBERS] {
    let [p, n] = [vertex.position, vertex.normal].map(|v| v.as_vec3());
    let (t, uv) = (vertex.tangent.as_vec4(), vertex.uv.as_vec2());
    let angle = vertex.orientation_angle as f32;
    [p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y, t.z, t.w, uv.x, uv.y, angle]
}

/// Compiles a pass for those targets.
pub(super) fn build(
    shared: &Arc<Shared>,
    program: &MeshProgram<'_>,
    targets: Targets,
) -> Result<MeshPipeline> {
    let device = &shared.device;
    let (mut layouts, mut views) = (Vec::new(), Vec::new());
    let sampled = |filterable, view_dimension| wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable },
        view_dimension,
        multisampled: false,
    };
    for texture in &program.textures {
        let filterable = texture.sampler.is_some();
        let ty = sampled(filterable, dimension(texture.layout));
        layouts.push(layout_entry(texture.binding, ty));
        views.push((texture.binding, upload(shared, program.name, texture)?));
    }
    let filtering = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let mut samplers: Vec<(u32, wgpu::Sampler)> =
        samplers(&program.textures).into_iter().map(|b| (b, linear(device))).collect();
    layouts.extend(samplers.iter().map(|(binding, _)| layout_entry(*binding, filtering)));
    if let Some(colours) = program.colours {
        layouts.push(layout_entry(colours.binding, sampled(true, wgpu::TextureViewDimension::D2)));
        views.push((colours.binding, colour_view(shared, colours.map)));
        layouts.push(layout_entry(colours.sampler, filtering));
        samplers.push((
            colours.sampler,
            device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("colours"),
                address_mode_u: wgpu::AddressMode::Repeat,
                address_mode_v: wgpu::AddressMode::Repeat,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            }),
        ));
    }
    let mut uniforms = Vec::new();
    for (binding, size) in &program.uniforms {
        let ty = wgpu::BufferBindingType::Uniform;
        let ty =
            wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        layouts.push(layout_entry(*binding, ty));
        uniforms.push((
            *binding,
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("uniform"),
                size: *size as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        ));
    }
    let entry = |binding: &u32, resource| wgpu::BindGroupEntry { binding: *binding, resource };
    let views = views.iter().map(|(b, v)| entry(b, wgpu::BindingResource::TextureView(v)));
    let samplers = samplers.iter().map(|(b, s)| entry(b, wgpu::BindingResource::Sampler(s)));
    let blocks = uniforms.iter().map(|(b, buffer)| entry(b, buffer.as_entire_binding()));
    let entries: Vec<_> = views.chain(samplers).chain(blocks).collect();
    let label = Some("group 0");
    let descriptor = wgpu::BindGroupLayoutDescriptor { label, entries: &layouts };
    let layout = device.create_bind_group_layout(&descriptor);
    let descriptor = wgpu::BindGroupDescriptor { label, layout: &layout, entries: &entries };
    let group = device.create_bind_group(&descriptor);
    let pipeline = pipeline(shared, program, targets, &layout);
    let uniforms = uniforms.iter().map(|(_, buffer)| buffer.clone()).collect();
    Ok(MeshPipeline { pipeline, group, uniforms })
}

fn pipeline(
    shared: &Shared,
    program: &MeshProgram<'_>,
    targets: Targets,
    layout: &wgpu::BindGroupLayout,
) -> wgpu::RenderPipeline {
    use wgpu::VertexFormat::{Float32, Float32x2, Float32x3, Float32x4};
    let device = &shared.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(program.name),
        source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(program.wgsl)),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(program.name),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    let formats = [Float32x3, Float32x3, Float32x4, Float32x2, Float32];
    let mut offset = 0;
    let attributes = formats.into_iter().zip(0..).map(|(format, shader_location)| {
        let attribute = wgpu::VertexAttribute { format, offset, shader_location };
        offset += format.size();
        attribute
    });
    let attributes: Vec<_> = attributes.collect();
    let target = wgpu::ColorTargetState {
        format: targets.format(),
        blend: None,
        write_mask: wgpu::ColorWrites::ALL,
    };
    let all = vec![Some(target); targets.pictures];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(program.name),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(program.vertex_entry),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: (VERTEX_NUMBERS * size_of::<f32>()) as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &attributes,
            })],
        },
        // both sides are drawn: back faces are black and hide what is behind them
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::LessEqual),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: targets.samples(), ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(program.fragment_entry),
            compilation_options: Default::default(),
            targets: &all,
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A pass with the bytes of its uniform blocks, in the order of their declaration.
pub type MeshPass<'a> = (&'a MeshPipeline, &'a [&'a [u8]]);

/// Draws a mesh. Returns pictures as `[picture][row][column]`, top row first; alpha is 0 outside the mesh.
pub(super) fn draw(
    shared: &Shared,
    name: &str,
    mesh: &MeshBuffers,
    (pipeline, uniforms): MeshPass<'_>,
    targets: Targets,
    [width, height]: [u32; 2],
) -> Result<Vec<Vec<[f32; 4]>>> {
    let side = shared.limits.max_texture_dimension_2d;
    if width == 0 || height == 0 || width > side || height > side {
        let cause = format!(
            "a picture of {width} × {height} pixels cannot be drawn: sides must be between 1 and {side}"
        );
        return Err(Error::new(name, cause).remedy("choose another size"));
    }
    let texture = |format, sample_count, usage| {
        shared.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("frame"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
    let single: Vec<_> = (0..targets.pictures)
        .map(|_| texture(targets.format(), 1, attachment | wgpu::TextureUsages::COPY_SRC))
        .collect();
    let many: Vec<_> = (0..targets.pictures)
        .filter(|_| targets.multisampled)
        .map(|_| texture(targets.format(), targets.samples(), attachment))
        .collect();
    let depth = texture(DEPTH, targets.samples(), attachment);
    let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
    let (singles, manys): (Vec<_>, Vec<_>) =
        (single.iter().map(view).collect(), many.iter().map(view).collect());
    let depth = view(&depth);
    let mut encoder = shared.device.create_command_encoder(&Default::default());
    for (buffer, bytes) in pipeline.uniforms.iter().zip(uniforms) {
        shared.queue.write_buffer(buffer, 0, bytes);
    }
    let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
    let ops = wgpu::Operations { load: clear, store: wgpu::StoreOp::Store };
    let attachments = singles.iter().enumerate().map(|(i, single)| {
        let (view, resolve_target) = match manys.get(i) {
            Some(many) => (many, Some(single)),
            None => (single, None),
        };
        Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target, ops })
    });
    let attachments: Vec<_> = attachments.collect();
    let depth_ops =
        wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(name),
        color_attachments: &attachments,
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth,
            depth_ops: Some(depth_ops),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline.pipeline);
    pass.set_bind_group(0, &pipeline.group, &[]);
    pass.set_vertex_buffer(0, mesh.vertices.slice(..));
    pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
    pass.draw_indexed(0..mesh.count, 0, 0..1);
    drop(pass);
    shared.queue.submit([encoder.finish()]);
    let read = |texture| {
        let encoder = shared.device.create_command_encoder(&Default::default());
        read_rows(shared, name, encoder, texture, 0..height)
    };
    single.iter().map(read).collect()
}

/// The picture with its mipmaps, read through the sRGB curve.
fn colour_view(shared: &Shared, map: &ColourMap) -> wgpu::TextureView {
    let levels = map.levels();
    let texture = shared.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("colours"),
        size: wgpu::Extent3d { width: map.width, height: map.height, depth_or_array_layers: 1 },
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (mip_level, level) in (0..).zip(&levels) {
        shared.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &texture,
                mip_level,
                origin: wgpu::Origin3d::ZERO,
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(&level.texels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * level.width),
                rows_per_image: None,
            },
            wgpu::Extent3d { width: level.width, height: level.height, depth_or_array_layers: 1 },
        );
    }
    texture.create_view(&Default::default())
}
