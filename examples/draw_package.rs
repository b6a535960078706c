//! Draws the BRDF map of a package's shader: manifest, WGSL and tables are read, the generated bindings say how to bind.
//!
//!     cargo run --release --features gpu --example draw_package -- [FOLDER] [PICTURE.png]

use std::{borrow::Cow, error::Error, fs, path::Path};

use diffraction_shaders::runner::gpu::*;

#[allow(
    dead_code,
    unused_qualifications,
    reason = "generated for any program; this one needs a part of it"
)]
mod bindings {
    include!("../generated/shaders/blazed/full-taylor-t19/bindings.rs");
}
use bindings::{PARAMS_BINDING, PARAMS_BYTES, Params, SURFACE, TABLES, Table, VARIANT};

const FOLDER: &str = "generated/shaders/blazed/full-taylor-t19";
const SIZE: u32 = 256;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or(FOLDER.to_owned());
    let read = |file: &str| fs::read(Path::new(&folder).join(file));
    let manifest: serde_json::Value = serde_json::from_slice(&read("manifest.json")?)?;
    if manifest["variant"] != VARIANT || manifest["surface"] != SURFACE {
        return Err(format!("{folder} is not what {FOLDER}/bindings.rs describes").into());
    }
    let text = manifest["targets"]["wgsl"][0]["file"].as_str().ok_or("the package has no WGSL")?;
    let wgsl = String::from_utf8(read(text)?)?;
    let texture = |table: Table| -> Result<Texture<'static>, Box<dyn Error>> {
        let layout =
            if table.dimension == "2d-array" { TextureLayout::D2Array } else { TextureLayout::D2 };
        assert_eq!(table.format, "rgba32float", "this variant's tables are");
        let (format, bytes) = (TextureFormat::Rgba32Float, Cow::Owned(read(table.data)?));
        let Table { binding, width, height, layers, sampler, .. } = table;
        Ok(Texture { binding, layout, format, width, height, layers, sampler, bytes })
    };
    let textures = TABLES.into_iter().map(texture).collect::<Result<_, _>>()?;
    let uniform = Some(Uniform { binding: PARAMS_BINDING, size: PARAMS_BYTES as u32 });
    let (name, vertex_entry, fragment_entry) = (VARIANT, "vert", "map");
    let shader = Shader::Wgsl(&wgsl);
    let program = Program { name, shader, vertex_entry, fragment_entry, textures, uniform };
    let pipeline = Gpu::open(Backend::Vulkan, None)?.program(&program)?;
    let (x, z) = 20_f32.to_radians().sin_cos();
    let params = Params { light: [x, 0.0, z, 0.0], size: [SIZE as f32, SIZE as f32, 0.0, 0.0] };
    let pixels = pipeline.render(SIZE, SIZE, bytemuck::cast_slice(&[params.light, params.size]))?;
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
