//! Draws the BRDF map of a package's variant with plain wgpu, reading manifest, WGSL and tables.
//!
//!     cargo run --release -p diffraction-harness --example wgpu -- generated/shaders/fingers/full-taylor-t19 map.png

use std::{collections::BTreeMap, env, error::Error, fs, path::Path, sync::mpsc};

use serde::Deserialize;
use serde_json::Value;
use wgpu::util::{BufferInitDescriptor, DeviceExt, DownloadBuffer, TextureDataOrder};
use wgpu::{
    BindGroupLayoutEntry, BindingResource, BindingType, BufferUsages, Device, FilterMode, Queue,
    ShaderStages, TextureFormat, TextureView, TextureViewDimension,
};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// What viewers in all directions see under a light 20° from the normal, exposed for a white
/// diffuser; square roots stand for the curve of sRGB. Fragment shaders call `diffraction` alike.
pub const MAP: &str = "
@group(1) @binding(0) var<storage, read_write> picture: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = vec2f(vec2u(id.x % 256, id.x / 256));
    let place = (2.0 * pixel + 1.0) / 256.0 - 1.0;
    let squared = 1.0 - dot(place, place);
    let wi = vec3f(sin(radians(20.0)), 0.0, cos(radians(20.0)));
    let wr = vec3f(place.x, -place.y, sqrt(max(0.0, squared)));
    let colour = DIFFUSER_SCALE * max(vec3f(0.0), diffraction(wi, wr));
    picture[id.x] = pack4x8unorm(vec4f(sqrt(colour), step(0.0, squared)));
}";

fn main() -> Result<()> {
    let arguments: Vec<String> = env::args().collect();
    let [_, folder, picture] = &arguments[..] else {
        return Err("usage: wgpu FOLDER PICTURE.png".into());
    };
    let pixels = run(&connect()?, Path::new(folder), MAP, 256, &[0; 4 * 256 * 256])?;
    Ok(image::save_buffer(picture, &pixels, 256, 256, image::ColorType::Rgba8)?)
}

/// A device with all that its adapter can: some tables are large.
pub fn connect() -> Result<(Device, Queue)> {
    let adapter = wgpu::Instance::default().request_adapter(&Default::default());
    let adapter = pollster::block_on(adapter)?;
    let needs = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    Ok(pollster::block_on(adapter.request_device(&needs))?)
}

/// Runs our entry point behind the variant's text, and returns what it makes of our buffer.
pub fn run(
    gpu: &(Device, Queue),
    folder: &Path,
    entry_point: &str,
    workgroups: u32,
    contents: &[u8],
) -> Result<Vec<u8>> {
    let (device, queue) = gpu;
    let manifest: Value = serde_json::from_slice(&fs::read(folder.join("manifest.json"))?)?;
    let file = <&str>::deserialize(&manifest["targets"]["wgsl"][0]["file"])?;
    let package = fs::read_to_string(folder.join(file))?;
    let scale = manifest["core"]["diffuser_scale"].as_f64().unwrap_or(1.0); // gems has none
    let text = format!("{package}\nconst DIFFUSER_SCALE = {scale:?};\n{entry_point}");
    let source = wgpu::ShaderSource::Wgsl(text.into());
    let module = wgpu::ShaderModuleDescriptor { label: None, source };

    // group 0 is the package's: tables, and a sampler in variants that let the driver interpolate
    let mut tables = BTreeMap::new();
    for table in Vec::<Value>::deserialize(&manifest["tables"])? {
        tables.insert(String::deserialize(&table["binding"])?, upload(gpu, folder, &table)?);
    }
    let (mag_filter, min_filter) = (FilterMode::Linear, FilterMode::Linear);
    let sampler = wgpu::SamplerDescriptor { mag_filter, min_filter, ..Default::default() };
    let sampler = device.create_sampler(&sampler);
    let (mut entries, mut layout) = (Vec::new(), Vec::new());
    for described in Vec::<Value>::deserialize(&manifest["bindings"])? {
        let filterable = described["sample_type"] == "float";
        let (resource, ty) = match tables.get(<&str>::deserialize(&described["name"])?) {
            Some(table) => {
                let sample_type = wgpu::TextureSampleType::Float { filterable };
                let view_dimension = dimension(&described);
                let ty = BindingType::Texture { sample_type, view_dimension, multisampled: false };
                (BindingResource::TextureView(table), ty)
            }
            None if described["kind"] == "sampler" => {
                let ty = BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
                (BindingResource::Sampler(&sampler), ty)
            }
            None => continue, // of the package's own entry points
        };
        let binding = u32::deserialize(&described["binding"])?;
        entries.push(wgpu::BindGroupEntry { binding, resource });
        layout.push(layout_entry(binding, ty));
    }

    // group 1 is ours
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let buffer = device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage });
    let ours = vec![wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }];
    let ty = wgpu::BufferBindingType::Storage { read_only: false };
    let ty = BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let groups = [(entries, layout), (ours, vec![layout_entry(0, ty)])];

    // an entry point may read some of the tables only, so the layouts are not derived from it
    let layouts = groups.each_ref().map(|(_, entries)| {
        let layout = wgpu::BindGroupLayoutDescriptor { label: None, entries };
        device.create_bind_group_layout(&layout)
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &layouts.each_ref().map(Some),
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: Some(&layout),
        module: &device.create_shader_module(module),
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });

    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    for (index, (layout, (entries, _))) in (0..).zip(layouts.iter().zip(&groups)) {
        let group = wgpu::BindGroupDescriptor { label: None, layout, entries };
        pass.set_bind_group(index, &device.create_bind_group(&group), &[]);
    }
    pass.dispatch_workgroups(workgroups, 1, 1);
    drop(pass);
    queue.submit([encoder.finish()]);
    let (send, receive) = mpsc::channel();
    let arrived = move |read| drop(send.send(read));
    DownloadBuffer::read_buffer(device, queue, &buffer.slice(..), arrived);
    device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(receive.recv()??.to_vec())
}

/// A table as a texture.
fn upload(gpu: &(Device, Queue), folder: &Path, table: &Value) -> Result<TextureView> {
    let shape = fs::read(folder.join(<&str>::deserialize(&table["description"])?))?;
    let shape: Value = serde_json::from_slice(&shape)?;
    let texels = fs::read(folder.join(<&str>::deserialize(&table["data"])?))?;
    let descriptor = wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: u32::deserialize(&shape["width"])?,
            height: u32::deserialize(&shape["height"])?,
            depth_or_array_layers: u32::deserialize(&shape["layers"])?,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: match <&str>::deserialize(&shape["format"])? {
            "rg16float" => TextureFormat::Rg16Float,
            "rgba16float" => TextureFormat::Rgba16Float,
            "rg32float" => TextureFormat::Rg32Float,
            "rgba32float" => TextureFormat::Rgba32Float,
            "rgb9e5ufloat" => TextureFormat::Rgb9e5Ufloat,
            other => return Err(format!("{other}: not a format of tables").into()),
        },
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = TextureDataOrder::LayerMajor;
    let texture = gpu.0.create_texture_with_data(&gpu.1, &descriptor, order, &texels);
    let dimension = Some(dimension(&shape));
    Ok(texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() }))
}

fn dimension(described: &Value) -> TextureViewDimension {
    match described["dimension"] == "2d-array" {
        true => TextureViewDimension::D2Array, // also where it has one layer
        false => TextureViewDimension::D2,
    }
}

fn layout_entry(binding: u32, ty: BindingType) -> BindGroupLayoutEntry {
    BindGroupLayoutEntry { binding, visibility: ShaderStages::COMPUTE, ty, count: None }
}
