//! A package in plain wgpu: manifest, WGSL and tables are read. Draws a variant's BRDF map, or evaluates its probes as JSON.
//!
//!     cargo run --release --features gpu --example wgpu -- generated/shaders/fingers/full-taylor-t19 map.png
//!     cargo run --release --features gpu --example wgpu -- generated/shaders/fingers/full-taylor-t19

use std::{error::Error, fs, path::Path};

use serde_json::{Value, json};

type Result<T> = std::result::Result<T, Box<dyn Error>>;
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("usage: wgpu FOLDER [PICTURE.png]")?;
    match arguments.next() {
        Some(picture) => map(&Variant::open(Path::new(&folder))?, 256)?.save(picture)?,
        None => println!("{}", run(Path::new(&folder))?),
    }
    Ok(())
}

/// Evaluates the probes of a variant.
pub fn run(folder: &Path) -> Result<Value> {
    probe(&Variant::open(folder)?, folder)
}

/// An adapter, and a variant's shader and tables on it.
pub struct Variant {
    device: wgpu::Device,
    queue: wgpu::Queue,
    module: wgpu::ShaderModule,
    tables: Vec<(u32, wgpu::TextureView)>,
    sampler: Option<(u32, wgpu::Sampler)>,
    adapter: String,
    manifest: Value,
}

impl Variant {
    /// Reads the variant in a folder and uploads it.
    pub fn open(folder: &Path) -> Result<Variant> {
        let json = |file: &str| -> Result<Value> {
            Ok(serde_json::from_slice(&fs::read(folder.join(file))?)?)
        };
        let manifest = json("manifest.json")?;
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
        let request =
            wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&request))?;
        let file =
            manifest["targets"]["wgsl"][0]["file"].as_str().ok_or("no WGSL in the package")?;
        let source = wgpu::ShaderSource::Wgsl(fs::read_to_string(folder.join(file))?.into());
        let module =
            device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
        let bindings = manifest["bindings"].as_array().ok_or("no bindings")?;
        let number = |binding: &Value| binding["binding"].as_u64().unwrap_or(0) as u32;
        let mut tables = Vec::new();
        for table in manifest["tables"].as_array().ok_or("no tables")? {
            let shape = json(table["description"].as_str().ok_or("no description")?)?;
            let bytes = fs::read(folder.join(table["data"].as_str().ok_or("no data")?))?;
            let binding = bindings.iter().find(|b| b["name"] == table["binding"]);
            let binding = number(binding.ok_or("a table without a binding")?);
            tables.push((binding, texture(&device, &queue, &shape, &bytes)?));
        }
        // of variants that let the driver interpolate
        let linear = wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        };
        let sampler = bindings.iter().find(|b| b["kind"] == "sampler");
        let sampler = sampler.map(|b| (number(b), device.create_sampler(&linear)));
        let info = adapter.get_info();
        let adapter = format!("{} {}", info.backend, info.name);
        Ok(Variant { adapter, device, queue, module, tables, sampler, manifest })
    }

    /// What the entry point gives for `width × height` pixels, the highest row first, and what it reads besides the tables.
    fn draw(
        &self,
        entry: &str,
        [width, height]: [u32; 2],
        params: [f32; 8],
        more: Option<(u32, wgpu::TextureView)>,
    ) -> Result<Vec<[f32; 4]>> {
        let (device, queue) = (&self.device, &self.queue);
        let module = &self.module;
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vert"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                targets: &[Some(FORMAT.into())],
            }),
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            multiview_mask: None,
            cache: None,
        });
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let uniform = buffer(device, 32, usage);
        queue.write_buffer(&uniform, 0, bytemuck::cast_slice(&params));
        let views = self.tables.iter().chain(&more);
        let mut entries: Vec<wgpu::BindGroupEntry<'_>> = views
            .map(|(binding, view)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: wgpu::BindingResource::TextureView(view),
            })
            .collect();
        entries.extend(self.sampler.iter().map(|(binding, sampler)| wgpu::BindGroupEntry {
            binding: *binding,
            resource: wgpu::BindingResource::Sampler(sampler),
        }));
        entries.push(wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() });
        let layout = &pipeline.get_bind_group_layout(0);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &entries,
        });
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let target = device.create_texture(&descriptor(size, FORMAT, usage));
        let view = target.create_view(&Default::default());
        let mut encoder = device.create_command_encoder(&Default::default());
        let attachment = wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: Default::default(),
        };
        let color_attachments = &[Some(attachment)];
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments,
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        // a row of 64 or 256 pixels is a multiple of the 256 bytes that copies ask for
        let bytes = u64::from(width * height * 16);
        let read =
            buffer(device, bytes, wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
        let layout =
            wgpu::TexelCopyBufferLayout { bytes_per_row: Some(16 * width), ..Default::default() };
        let into = wgpu::TexelCopyBufferInfo { buffer: &read, layout };
        encoder.copy_texture_to_buffer(target.as_image_copy(), into, size);
        queue.submit([encoder.finish()]);
        read.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        device.poll(wgpu::PollType::wait_indefinitely())?;
        let view = read.slice(..).get_mapped_range()?;
        Ok(bytemuck::cast_slice(&view).to_vec())
    }
}

/// The BRDF map under a light 20° from the normal.
pub fn map(variant: &Variant, size: u32) -> Result<image::RgbaImage> {
    let (x, z) = 20_f32.to_radians().sin_cos();
    let params = [x, 0.0, z, 0.0, size as f32, size as f32, 0.0, 0.0];
    let pixels = variant.draw("map", [size, size], params, None)?;
    // the brightest tenth of a percent is white; square roots stand for the curve of sRGB
    let mut greens: Vec<f32> = pixels.iter().map(|pixel| pixel[1]).collect();
    greens.sort_by(f32::total_cmp);
    let white = greens[greens.len() - greens.len() / 1000];
    let encode = |v: f32| (255.0 * (v / white).clamp(0.0, 1.0).sqrt()) as u8;
    Ok(image::RgbaImage::from_fn(size, size, |x, y| {
        let [r, g, b, a] = pixels[(y * size + x) as usize];
        image::Rgba([encode(r), encode(g), encode(b), (255.0 * a) as u8])
    }))
}

/// The greatest error of XYZ over the tolerance of its direction, and the same for integrations that are wrong on purpose.
fn probe(variant: &Variant, folder: &Path) -> Result<Value> {
    let probes: Value = serde_json::from_slice(&fs::read(folder.join("probe.json"))?)?;
    let probes = probes["probes"].as_array().ok_or("no probes")?;
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let evaluate = |sign: f32| -> Result<Vec<[f32; 4]>> {
        let row = |key: &'static str| {
            let texel = move |p: &Value| {
                [0, 1, 2].map(|c| number(&p[key][c]) as f32 * if c == 1 { sign } else { 1.0 })
            };
            probes.iter().flat_map(move |p| {
                let [x, y, z] = texel(p);
                [x, y, z, 0.0]
            })
        };
        let texels: Vec<f32> = row("wi").chain(row("wr")).collect();
        let shape = json!({"format": "rgba32float", "dimension": "2d", "width": probes.len(), "height": 2, "layers": 1});
        let view = texture(&variant.device, &variant.queue, &shape, bytemuck::cast_slice(&texels))?;
        let width = probes.len() as u32;
        let params = [0.0, 0.0, 0.0, 0.0, width as f32, 1.0, 0.0, 0.0];
        variant.draw("probe", [width, 1], params, Some((3, view)))
    };
    let worst = |seen: &[[f32; 4]], order: [usize; 3]| -> f64 {
        let ratio = |(seen, probe): (&[f32; 4], &Value)| {
            let error =
                |c: usize| (f64::from(seen[order[c]]) - number(&probe["expected"]["xyz"][c])).abs();
            let ratios = [0, 1, 2].map(|c| error(c) / number(&probe["tolerance"]));
            // what is not a number counts as wrong
            ratios.map(|r| if r.is_finite() { r } else { f64::MAX }).into_iter().fold(0.0, f64::max)
        };
        seen.iter().zip(probes).map(ratio).fold(0.0, f64::max)
    };
    let (seen, flipped) = (evaluate(1.0)?, evaluate(-1.0)?);
    Ok(json!({
        "driver": variant.adapter, "surface": variant.manifest["surface"], "variant": variant.manifest["variant"], "count": probes.len(),
        "worst": worst(&seen, [0, 1, 2]),
        "controls": {"swapped channels": worst(&seen, [2, 1, 0]), "flipped bitangent": worst(&flipped, [0, 1, 2])},
    }))
}

/// A table as a texture, from its description.
fn texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    shape: &Value,
    bytes: &[u8],
) -> Result<wgpu::TextureView> {
    let number = |key: &str| shape[key].as_u64().map(|n| n as u32).ok_or("no size");
    let (width, height, layers) = (number("width")?, number("height")?, number("layers")?);
    let format = match shape["format"].as_str().ok_or("no format")? {
        "rg16float" => wgpu::TextureFormat::Rg16Float,
        "rgba16float" => wgpu::TextureFormat::Rgba16Float,
        "rg32float" => wgpu::TextureFormat::Rg32Float,
        "rgba32float" => wgpu::TextureFormat::Rgba32Float,
        "rgb9e5ufloat" => wgpu::TextureFormat::Rgb9e5Ufloat,
        other => return Err(format!("{other}: not a format of tables").into()),
    };
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: layers };
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let texture = device.create_texture(&descriptor(size, format, usage));
    let bytes_per_row = Some(bytes.len() as u32 / (height * layers));
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: Some(height) };
    queue.write_texture(texture.as_image_copy(), bytes, layout, size);
    let is_array = shape["dimension"] == "2d-array";
    let dimension =
        if is_array { wgpu::TextureViewDimension::D2Array } else { wgpu::TextureViewDimension::D2 };
    Ok(texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(dimension),
        ..Default::default()
    }))
}

fn descriptor(
    size: wgpu::Extent3d,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}

fn buffer(device: &wgpu::Device, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage,
        mapped_at_creation: false,
    })
}
