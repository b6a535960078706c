//! The wgpu runner on the software drivers of both backends.

use crate::support::tools;
use std::{borrow::Cow, process::Command};

use diffraction_harness::drivers::gpu::{
    Backend, Gpu, MESA_FLOAT_TARGETS, Pipeline, Program, Shader, Texture, TextureFormat,
    TextureLayout, Uniform,
};

const TRIANGLE: &str = "
@vertex fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
";

/// Runs `test` on both backends. A missing driver is a failure where the tools are required, else it is said.
fn on_both(test: impl Fn(&Gpu)) {
    for backend in [Backend::Vulkan, Backend::Gl] {
        if let Some(gpu) = tools::found(Gpu::open(backend, None)) {
            test(&gpu);
        }
    }
}

fn program<'a>(wgsl: &'a str, textures: Vec<Texture<'a>>, uniform: Option<Uniform>) -> Program<'a> {
    Program {
        name: "test",
        shader: Shader::Wgsl(wgsl),
        vertex_entry: "vertex",
        fragment_entry: "fragment",
        textures,
        uniform,
    }
}

fn compile(
    gpu: &Gpu,
    fragment: &str,
    textures: Vec<Texture<'_>>,
    uniform: Option<Uniform>,
) -> Pipeline {
    gpu.program(&program(&format!("{TRIANGLE}{fragment}"), textures, uniform))
        .expect("valid program")
}

fn array(
    format: TextureFormat,
    width: u32,
    height: u32,
    layers: u32,
    bytes: Vec<u8>,
) -> Texture<'static> {
    Texture {
        binding: 0,
        layout: TextureLayout::D2Array,
        format,
        width,
        height,
        layers,
        sampler: None,
        bytes: Cow::Owned(bytes),
    }
}

#[test]
fn the_first_row_is_at_the_top() {
    // normalised device coordinates, handed on by the vertex stage: independent of where a backend has its origin
    let shader = r#"
struct Corner { @builtin(position) place: vec4f, @location(0) ndc: vec2f }
@vertex fn vertex(@builtin(vertex_index) i: u32) -> Corner {
    let ndc = vec2f(f32(i & 1u), f32(i >> 1u)) * 4.0 - 1.0;
    return Corner(vec4f(ndc, 0.0, 1.0), ndc);
}
@fragment fn fragment(at: Corner) -> @location(0) vec4f { return vec4f(at.ndc, at.place.xy); }
"#;
    let (width, height) = (7, 5);
    on_both(|gpu| {
        let pipeline = gpu.program(&program(shader, vec![], None)).expect("valid program");
        let pixels = pipeline.render(width, height, &[]).expect("renders");
        assert_eq!(pixels.len(), 35);
        for (i, pixel) in (0..).zip(&pixels) {
            let (x, y) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
            let wanted = [2.0 * x / width as f32 - 1.0, 1.0 - 2.0 * y / height as f32, x, y];
            for (got, wanted) in pixel.iter().zip(wanted) {
                assert!((got - wanted).abs() < 1e-5, "{}: pixel {i}: {pixel:?}", gpu.info());
            }
        }
    });
}

#[test]
fn array_texels_arrive_exactly() {
    // 1 layer and squares with 6 and 12: the shapes that wgpu's GL takes for something else than an array
    for (width, height, layers) in [(5, 3, 4), (4, 3, 1), (4, 4, 6), (4, 4, 12), (1, 1, 6)] {
        let value = |layer, y, x, channel| {
            // every bit of the mantissa in use
            0.1_f32 + (((layer * height + y) * width + x) * 4 + channel) as f32 / 3.0
        };
        let mut bytes = Vec::new();
        for i in 0..layers * height * width * 4 {
            let (texel, channel) = (i / 4, i % 4);
            let (layer, y, x) = (texel / (width * height), texel / width % height, texel % width);
            bytes.extend(value(layer, y, x, channel).to_le_bytes());
        }
        // layers beside each other: column = layer * width + x
        let shader = format!(
            r#"@group(0) @binding(0) var table: texture_2d_array<f32>;
             @fragment fn fragment(@builtin(position) p: vec4f) -> @location(0) vec4f {{
                 let at = vec2i(p.xy);
                 return textureLoad(table, vec2i(at.x % {width}, at.y), at.x / {width}, 0);
             }}"#
        );
        on_both(|gpu| {
            let table = array(TextureFormat::Rgba32Float, width, height, layers, bytes.clone());
            let pipeline = compile(gpu, &shader, vec![table], None);
            let columns = width * layers;
            let pixels = pipeline.render(columns, height, &[]).expect("renders");
            for (i, pixel) in (0..).zip(pixels) {
                let (column, y) = (i % columns, i / columns);
                let wanted = [0, 1, 2, 3].map(|c| value(column / width, y, column % width, c));
                assert_eq!(
                    pixel,
                    wanted,
                    "{} {}: {width}x{height}x{layers}",
                    gpu.info().backend,
                    gpu.info()
                );
            }
        });
    }
}

#[test]
fn every_format_is_read_and_large_textures_go_up_in_pieces() {
    let shader = r#"@group(0) @binding(0) var table: texture_2d_array<f32>;
        @fragment fn fragment(@builtin(position) p: vec4f) -> @location(0) vec4f {
            let side = textureDimensions(table);
            return textureLoad(table, vec2u(u32(p.x), side.y - 1u), 1, 0);
        }"#;
    let last = |format: TextureFormat, height: u32, texel: &[u8]| {
        let mut bytes = vec![0; 2 * height as usize * 2 * texel.len()];
        let end = bytes.len();
        bytes[end - texel.len()..].copy_from_slice(texel);
        array(format, 2, height, 2, bytes)
    };
    let f32s = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    // 1.5, -2, 0.25, 1024 as f16
    let f16s: Vec<u8> =
        [0x3e00_u16, 0xc000, 0x3400, 0x6400].iter().flat_map(|v| v.to_le_bytes()).collect();
    on_both(|gpu| {
        for (table, wanted) in [
            (last(TextureFormat::Rg32Float, 3, &f32s(&[0.1, -7e20])), [0.1, -7e20, 0.0, 1.0]),
            (last(TextureFormat::Rg16Float, 3, &f16s[..4]), [1.5, -2.0, 0.0, 1.0]),
            (last(TextureFormat::Rgba16Float, 3, &f16s), [1.5, -2.0, 0.25, 1024.0]),
        ] {
            let pipeline = compile(gpu, shader, vec![table], None);
            assert_eq!(pipeline.render(2, 1, &[]).expect("renders")[1], wanted, "{}", gpu.info());
        }
        // 2 × 40 MiB
        let (width, height) = (1280, 2048);
        let texels = (0..2 * width * height).flat_map(|i: u32| [i as f32, 1.0, 2.0, 3.0]);
        let bytes = texels.flat_map(f32::to_le_bytes).collect();
        let table = array(TextureFormat::Rgba32Float, width, height, 2, bytes);
        let row = compile(gpu, shader, vec![table], None).render(width, 1, &[]).expect("renders");
        for (x, pixel) in (0..).zip(row) {
            assert_eq!(pixel[0], ((2 * height - 1) * width + x) as f32);
        }
    });
}

#[test]
fn bands_change_nothing() {
    let shader = "@group(0) @binding(3) var<uniform> scale: vec4f;
        @fragment fn fragment(@builtin(position) p: vec4f) -> @location(0) vec4f { return p * scale; }";
    let bytes = |v: [f32; 4]| v.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    on_both(|gpu| {
        let pipeline = compile(gpu, shader, vec![], Some(Uniform { binding: 3, size: 16 }));
        let scale = bytes([1.0, 10.0, 1.0, 0.5]);
        let whole = pipeline.render(20, 13, &scale).expect("renders");
        assert_eq!(whole[20 * 12 + 19], [19.5, 125.0, 0.0, 0.5]);
        let bands = [0..4, 4..8, 8..12, 12..13];
        let rows = |band| pipeline.rows([20, 13], &scale, band).expect("renders");
        assert_eq!(bands.map(rows).concat(), whole);
        assert_eq!(
            pipeline.render(1, 1, &bytes([2.0; 4])).expect("renders"),
            [[1.0, 1.0, 0.0, 2.0]]
        );
        assert!(pipeline.time(20, 13, &scale).expect("renders").as_nanos() > 0);
        assert!(pipeline.render(20, 13, &[]).is_err(), "no bytes for the uniform block");
    });
}

#[test]
fn what_is_wrong_is_an_error_that_names_it() {
    let good = "@fragment fn fragment() -> @location(0) vec4f { return vec4f(1.0); }";
    on_both(|gpu| {
        for (fragment, words) in [
            ("@fragment fn fragment() -> @location(0) vec4f { return missing; }", "missing"),
            ("@fragment fn fragment() -> @location(0) vec4f { return vec2f(1.0); }", "fragment"),
            ("@fragment fn other() -> @location(0) vec4f { return vec4f(1.0); }", "fragment"),
            (
                "@group(0) @binding(7) var t: texture_2d<f32>;
                 @fragment fn fragment() -> @location(0) vec4f { return textureLoad(t, vec2i(0), 0); }",
                "7",
            ),
            ("@fragment fn fragment() -> @location(0) vec4u { return vec4u(1u); }", "loat"),
        ] {
            let text = format!("{TRIANGLE}{fragment}");
            let error = gpu.program(&program(&text, vec![], None)).expect_err(fragment).to_string();
            assert!(error.starts_with("test: ") && error.contains(words), "{error}");
        }
        let text = format!("{TRIANGLE}{good}");
        let f = TextureFormat::Rg32Float;
        let flat = Texture { layout: TextureLayout::D2, ..array(f, 1, 1, 2, vec![0; 16]) };
        for (texture, words) in [
            (array(f, 1, 1, 1_000_000, vec![]), "max_texture_array_layers"),
            (array(f, 1_000_000, 1, 1, vec![]), "max_texture_dimension_2d"),
            (array(f, 2, 2, 2, vec![0; 63]), "take 64"),
            (array(f, 0, 2, 2, vec![]), "is empty"),
            (flat, "texture_2d_array"),
        ] {
            let error =
                gpu.program(&program(&text, vec![texture], None)).expect_err(words).to_string();
            assert!(error.contains("binding 0") && error.contains(words), "{error}");
        }
        let error = gpu.program(&program(&text, vec![], Some(Uniform { binding: 0, size: 20 })));
        assert!(error.expect_err("odd size").to_string().contains("multiple of 16"));
        // and the device is none the worse for it
        let pipeline = compile(gpu, good, vec![], None);
        assert_eq!(pipeline.render(1, 1, &[]).expect("renders"), [[1.0; 4]]);
        let error = pipeline.render(1_000_000, 1, &[]).expect_err("too wide").to_string();
        assert!(error.contains("max_texture_dimension_2d"), "{error}");
    });
}

#[test]
fn an_unknown_adapter_gives_the_listing() {
    let found = Gpu::adapters();
    for backend in [Backend::Vulkan, Backend::Gl] {
        let error = Gpu::open(backend, Some("no such adapter")).expect_err("unknown").to_string();
        assert!(error.contains("no such adapter") && error.contains("libegl1 libgles2"), "{error}");
        for info in &found {
            assert!(error.contains(&info.to_string()), "{error} lacks {info}");
        }
    }
    assert!("opengl".parse::<Backend>().is_err());
    assert_eq!("gl".parse::<Backend>().expect("a backend"), Backend::Gl);
    on_both(|gpu| {
        let name = gpu.info().name.to_uppercase();
        assert_eq!(
            Gpu::open(gpu.info().backend, Some(&name)).expect("by its name").info(),
            gpu.info()
        );
    });
}

#[test]
fn pipelines_of_one_device_serve_many_threads() {
    on_both(|gpu| {
        let shader = "@fragment fn fragment(@builtin(position) p: vec4f) -> @location(0) vec4f { return p; }";
        let pipeline = compile(gpu, shader, vec![], None);
        let wanted = pipeline.render(40, 30, &[]).expect("renders");
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..5 {
                        assert_eq!(pipeline.render(40, 30, &[]).expect("renders"), wanted);
                    }
                });
            }
        });
    });
}

/// Not a test of its own: what the next test runs without the environment of this process.
#[test]
#[ignore = "run by gl_without_float_targets_says_what_to_set"]
fn open_gl() {
    match Gpu::open(Backend::Gl, None) {
        Ok(gpu) => println!("opened {}", gpu.info()),
        Err(e) => println!("refused {e}"),
    }
}

#[test]
fn gl_without_float_targets_says_what_to_set() {
    let (name, value) = MESA_FLOAT_TARGETS;
    let run = |set: bool| {
        let mut command = Command::new(std::env::current_exe().expect("this test"));
        command.args(["--exact", "gpu::open_gl", "--ignored", "--nocapture"]).env_remove(name);
        if set {
            command.env(name, value);
        }
        String::from_utf8(command.output().expect("runs").stdout).expect("text")
    };
    let with = run(true);
    if with.contains("no adapter") {
        return tools::missing(with);
    }
    assert!(with.contains("opened "), "{with}");
    let without = run(false);
    // drivers other than Mesa's, and later ones, may need no persuasion
    assert!(
        without.contains("opened ") || without.contains(&format!("{name}={value}")),
        "{without}"
    );
}
