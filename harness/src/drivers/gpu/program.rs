//! A program to run: a shader, its textures, its uniform block.

use std::{borrow::Cow, collections::BTreeSet, sync::Arc};

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::shader::module::Stage;

use super::{Backend, guard::Shared, render::Pipeline, render::TARGET, spirv};

/// A shader with everything it reads.
#[derive(Clone, Debug)]
pub struct Program<'a> {
    /// Name of the variant, for errors.
    pub name: &'a str,
    /// The shader to compile.
    pub shader: Shader<'a>,
    /// An entry point that takes `vertex_index` 0, 1, 2 and covers the target with that triangle.
    pub vertex_entry: &'a str,
    /// An entry point that returns one `vec4f` at location 0.
    pub fragment_entry: &'a str,
    /// The textures of group 0.
    pub textures: Vec<Texture<'a>>,
    /// The uniform block of group 0, if any. Its bytes come with each frame.
    pub uniform: Option<Uniform>,
}

/// Source of a program.
#[derive(Clone, Copy, Debug)]
pub enum Shader<'a> {
    /// WGSL with both entry points, which wgpu translates.
    Wgsl(&'a str),
    /// SPIR-V words that Vulkan's driver gets unchanged: one module per stage.
    ///
    /// Only the form of the words is checked. Words of a right form that break the rules of SPIR-V can crash the driver: they must
    /// come from a compiler, or have passed `spirv-val`.
    Spirv {
        /// The module of the vertex entry point.
        vertex: &'a [u32],
        /// The module of the fragment entry point.
        fragment: &'a [u32],
    },
}

/// A texture that shaders read at level 0.
#[derive(Clone, Debug)]
pub struct Texture<'a> {
    /// `@binding` in group 0.
    pub binding: u32,
    /// The type in the shader.
    pub layout: TextureLayout,
    /// The type of its texels.
    pub format: TextureFormat,
    /// Texels per row.
    pub width: u32,
    /// Rows per layer.
    pub height: u32,
    /// Number of layers; 1 for [`TextureLayout::D2`]. On GL `textureNumLayers` may return one more, see [`TextureLayout::D2Array`].
    pub layers: u32,
    /// `@binding` in group 0 of its sampler, which is linear and clamps to the edge. `None`: the shader only uses `textureLoad`.
    pub sampler: Option<u32>,
    /// Texels in little-endian order, `[layer][row][column]`, without padding.
    pub bytes: Cow<'a, [u8]>,
}

/// The type of a texture in the shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureLayout {
    /// `texture_2d<f32>`.
    D2,
    /// `texture_2d_array<f32>`.
    ///
    /// wgpu's GL guesses the type from the shape of a texture: it takes a single layer for a `texture_2d`, and squares in multiples
    /// of six layers for cubes. There, such an array gets one more layer of zeros.
    D2Array,
}

/// The type of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureFormat {
    /// Two f32.
    Rg32Float,
    /// Four f32.
    Rgba32Float,
    /// Two f16.
    Rg16Float,
    /// Four f16.
    Rgba16Float,
    /// Three numbers of nine bits with one exponent.
    Rgb9e5Ufloat,
}

impl TextureFormat {
    /// Bytes of a texel.
    pub fn bytes(self) -> u32 {
        match self {
            TextureFormat::Rg16Float | TextureFormat::Rgb9e5Ufloat => 4,
            TextureFormat::Rg32Float | TextureFormat::Rgba16Float => 8,
            TextureFormat::Rgba32Float => 16,
        }
    }

    fn wgpu(self) -> wgpu::TextureFormat {
        match self {
            TextureFormat::Rg32Float => wgpu::TextureFormat::Rg32Float,
            TextureFormat::Rgba32Float => wgpu::TextureFormat::Rgba32Float,
            TextureFormat::Rg16Float => wgpu::TextureFormat::Rg16Float,
            TextureFormat::Rgba16Float => wgpu::TextureFormat::Rgba16Float,
            TextureFormat::Rgb9e5Ufloat => wgpu::TextureFormat::Rgb9e5Ufloat,
        }
    }
}

/// A uniform block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Uniform {
    /// `@binding` in group 0.
    pub binding: u32,
    /// Its size in bytes, padding included; a multiple of 16.
    pub size: u32,
}

/// Refuses programs that are inconsistent or above the adapter's limits.
pub(super) fn check(program: &Program<'_>, shared: &Shared) -> Result<()> {
    let limits = &shared.limits;
    if let Shader::Spirv { vertex, fragment } = program.shader {
        spirv::supported(shared)?;
        let bound: BTreeSet<u32> = bindings(program).collect();
        for (stage, entry, words) in [
            (Stage::Vertex, program.vertex_entry, vertex),
            (Stage::Fragment, program.fragment_entry, fragment),
        ] {
            spirv::check(words, stage, entry, &bound)
                .map_err(|cause| Error::new(format!("{}: {entry}", program.name), cause))?;
        }
    }
    for texture in &program.textures {
        let Texture { binding, layout, format, width, height, layers, ref bytes, .. } = *texture;
        let fail = |cause: String| {
            Error::new(format!("{}: texture at binding {binding}", program.name), cause)
        };
        if width == 0 || height == 0 || layers == 0 {
            return Err(fail(format!("is empty: {width} × {height} × {layers} texels")));
        }
        if layout == TextureLayout::D2 && layers != 1 {
            return Err(fail(format!("has {layers} layers, but a texture_2d has one"))
                .remedy("bind it as a texture_2d_array"));
        }
        let side = limits.max_texture_dimension_2d;
        if width > side || height > side {
            return Err(fail(format!(
                "has {width} × {height} texels, but max_texture_dimension_2d is {side}"
            ))
            .remedy("use fewer frequencies, or another adapter"));
        }
        let max = limits.max_texture_array_layers;
        if layers > max {
            return Err(fail(format!(
                "has {layers} layers, but max_texture_array_layers is {max}"
            ))
            .remedy("use fewer terms, or paired packing"));
        }
        let needed =
            u64::from(width) * u64::from(height) * u64::from(layers) * u64::from(format.bytes());
        if bytes.len() as u64 != needed {
            return Err(fail(format!(
                "has {} bytes, but {width} × {height} × {layers} texels of {format:?} take {needed}",
                bytes.len()
            )));
        }
    }
    if let Some(Uniform { binding, size }) = program.uniform {
        let max = limits.max_uniform_buffer_binding_size;
        let subject = format!("{}: uniform block at binding {binding}", program.name);
        if u64::from(size) > max {
            return Err(Error::new(
                subject,
                format!("has {size} bytes, but max_uniform_buffer_binding_size is {max}"),
            ));
        }
        if size == 0 || size % 16 != 0 {
            return Err(Error::new(subject, format!("has a size of {size} bytes"))
                .remedy("pad it to a multiple of 16"));
        }
    }
    Ok(())
}

/// Creates everything on the device. The caller checks for errors of wgpu.
pub(super) fn build(shared: &Arc<Shared>, program: &Program<'_>) -> Result<Pipeline> {
    let device = &shared.device;
    let mut layouts = Vec::new();
    let mut views = Vec::new();
    let fillers = match program.shader {
        Shader::Wgsl(_) => Vec::new(),
        Shader::Spirv { .. } => fillers(program),
    };
    for texture in program.textures.iter().chain(&fillers) {
        layouts.push(layout_entry(
            texture.binding,
            wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float {
                    filterable: texture.sampler.is_some(),
                },
                view_dimension: dimension(texture.layout),
                multisampled: false,
            },
        ));
        views.push((texture.binding, upload(shared, program.name, texture)?));
    }
    let samplers: Vec<(u32, wgpu::Sampler)> =
        samplers(&program.textures).into_iter().map(|binding| (binding, linear(device))).collect();
    for (binding, _) in &samplers {
        let ty = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        layouts.push(layout_entry(*binding, ty));
    }
    let buffer = program.uniform.map(|uniform| {
        let ty = wgpu::BufferBindingType::Uniform;
        layouts.push(layout_entry(
            uniform.binding,
            wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        ));
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("uniform"),
            size: u64::from(uniform.size),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    });
    let mut entries: Vec<_> = views
        .iter()
        .map(|(binding, view)| wgpu::BindGroupEntry {
            binding: *binding,
            resource: wgpu::BindingResource::TextureView(view),
        })
        .collect();
    entries.extend(samplers.iter().map(|(binding, sampler)| wgpu::BindGroupEntry {
        binding: *binding,
        resource: wgpu::BindingResource::Sampler(sampler),
    }));
    if let (Some(uniform), Some(buffer)) = (program.uniform, &buffer) {
        let resource = buffer.as_entire_binding();
        entries.push(wgpu::BindGroupEntry { binding: uniform.binding, resource });
    }
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("group 0"),
        entries: &layouts,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("group 0"),
        layout: &layout,
        entries: &entries,
    });
    let (vertex, fragment) = match program.shader {
        Shader::Wgsl(text) => {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(program.name),
                source: wgpu::ShaderSource::Wgsl(text.into()),
            });
            (module.clone(), module)
        }
        Shader::Spirv { vertex, fragment } => (
            spirv::module(device, program.vertex_entry, vertex),
            spirv::module(device, program.fragment_entry, fragment),
        ),
    };
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(program.name),
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(program.name),
        layout: Some(&pipeline_layout),
        vertex: wgpu::VertexState {
            module: &vertex,
            entry_point: Some(program.vertex_entry),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &fragment,
            entry_point: Some(program.fragment_entry),
            compilation_options: Default::default(),
            targets: &[Some(TARGET.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let uniform = buffer.zip(program.uniform).map(|(buffer, uniform)| (buffer, uniform.size));
    Ok(Pipeline::new(Arc::clone(shared), program.name, pipeline, group, uniform))
}

/// Textures of one texel for all unused bindings below the last used one.
///
/// wgpu renumbers the bindings of a layout without gaps, and rewrites the shaders that it translates. Unchanged SPIR-V
/// therefore needs a layout without gaps.
fn fillers(program: &Program<'_>) -> Vec<Texture<'static>> {
    let used: BTreeSet<u32> = bindings(program).collect();
    let last = used.last().copied().unwrap_or(0);
    let filler = |binding| Texture {
        binding,
        layout: TextureLayout::D2,
        format: TextureFormat::Rgba32Float,
        width: 1,
        height: 1,
        layers: 1,
        sampler: None,
        bytes: Cow::Owned(vec![0; 16]),
    };
    (0..last).filter(|binding| !used.contains(binding)).map(filler).collect()
}

/// The bindings of group 0 that the program uses.
fn bindings(program: &Program<'_>) -> impl Iterator<Item = u32> {
    let textures = program.textures.iter().map(|texture| texture.binding);
    let uniform = program.uniform.map(|uniform| uniform.binding);
    textures.chain(uniform).chain(samplers(&program.textures))
}

/// The bindings of the textures' samplers, each once.
pub(super) fn samplers(textures: &[Texture<'_>]) -> BTreeSet<u32> {
    textures.iter().filter_map(|texture| texture.sampler).collect()
}

/// A sampler: linear between texels, clamped to the edge.
pub(super) fn linear(device: &wgpu::Device) -> wgpu::Sampler {
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("linear"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    })
}

pub(super) fn layout_entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    let visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

pub(super) fn dimension(layout: TextureLayout) -> wgpu::TextureViewDimension {
    match layout {
        TextureLayout::D2 => wgpu::TextureViewDimension::D2,
        TextureLayout::D2Array => wgpu::TextureViewDimension::D2Array,
    }
}

/// Copies a texture to the device in pieces, so that the staging memory stays small.
pub(super) fn upload(
    shared: &Shared,
    name: &str,
    texture: &Texture<'_>,
) -> Result<wgpu::TextureView> {
    const PIECE: u64 = 32 << 20;
    let Texture { layout, format, width, height, layers, ref bytes, .. } = *texture;
    let misread = layers == 1 || (width == height && layers % 6 == 0);
    let padded = shared.info.backend == Backend::Gl && layout == TextureLayout::D2Array && misread;
    let target = shared.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("table"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers + u32::from(padded) },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: format.wgpu(),
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let bytes_per_row = width * format.bytes();
    let rows_per_piece = u32::try_from((PIECE / u64::from(bytes_per_row)).max(1)).unwrap_or(height);
    let row = bytes_per_row as usize;
    let mut staged = 0;
    for (layer, texels) in (0..layers).zip(bytes.chunks_exact(row * height as usize)) {
        for (y, piece) in
            (0..).step_by(rows_per_piece as usize).zip(texels.chunks(row * rows_per_piece as usize))
        {
            shared.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &target,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: 0, y, z: layer },
                    aspect: wgpu::TextureAspect::All,
                },
                piece,
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(bytes_per_row),
                    rows_per_image: None,
                },
                wgpu::Extent3d {
                    width,
                    height: rows_per_piece.min(height - y),
                    depth_or_array_layers: 1,
                },
            );
            staged += piece.len() as u64;
            if staged >= PIECE {
                staged = 0;
                let submission = shared.queue.submit([]);
                shared.wait(name, &submission)?;
            }
        }
    }
    Ok(target.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(dimension(layout)),
        ..Default::default()
    }))
}
