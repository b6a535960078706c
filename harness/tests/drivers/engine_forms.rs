//! What an integrator does: a package's function forms behind code that is not ours, its tables from their files, its
//! probes as the judge. So it is tested that function forms compute what whole shaders do, and that probes tell a right
//! integration from a wrong one on real drivers.

use crate::support::tools::found;
use std::borrow::Cow;
use std::path::Path;

use diffraction_harness::drivers::Driver;
use diffraction_harness::drivers::egl::{Dialect, Egl};
use diffraction_harness::drivers::gpu::{
    Backend, Gpu, Program, Shader, Texture, TextureFormat, TextureLayout, Uniform,
};
use diffraction_harness::drivers::passthrough::{Language, Passthrough};
use diffraction_shaders::Compiler;
use diffraction_shaders::package::Package;
use diffraction_shaders::plan::{Plan, Target};
use diffraction_shaders::shader::emit::{BindingKind, BindingName, EmittedFile, EntryPoint};
use diffraction_shaders::shader::module::Stage;
use diffraction_shaders::tables::{DIRECTIONS, Table, TexelFormat};
use serde_json::Value;

/// Every mode, both formats and packings, on a surface with orders along both axes and on a rough one.
const PLAN: &str = r#"schema = 1
[[surface]]
name = "crossed"
rotate_deg = 30
[surface.grating]
kind = "crossed"
x = { kind = "lamellar", period_um = 1.6, height_um = 0.12, pixels = 40, duty = 0.69 }
y = { kind = "blazed", period_um = 1.0, height_um = 0.1, pixels = 30 }
[[surface]]
name = "fingers"
grating = { kind = "fingers", size_um = 6.6, pixels = 90, pitch_um = 1.1, height_um = 0.3, seed = 3 }
[variants]
mode = ["full", "pq", "adaptive"]
terms = ["auto"]
[[preset]]
name = "half"
table = "f16"
packing = "single"
terms = 19
[[preset]]
name = "mean"
mode = "adaptive"
coherence = "ensemble"
[[preset]]
name = "printed"
basis = "taylor-zero"
hoist = false
terms = 31
[[preset]]
name = "comparator"
mode = "gems"
"#;

type Pair = [[f64; 3]; 2];
type Fault = fn(Pair) -> Pair;

const MIRRORED: &str = "mirrored bitangent";
const FAULTS: [(&str, Fault); 3] = [
    (MIRRORED, |pair| pair.map(|[x, y, z]| [x, -y, z])),
    ("tangent for bitangent", |pair| pair.map(|[x, y, z]| [y, x, z])),
    ("light that points to the surface", |[wi, wr]| [wi.map(|v| -v), wr]),
];

/// The probes of a package in order: directions, what is expected in XYZ and RGB, tolerance.
struct Probes {
    directions: Vec<Pair>,
    expected: Vec<Pair>,
    tolerance: Vec<f64>,
}

/// A variant of a package as its files describe it.
struct Variant<'a> {
    package: &'a Package,
    folder: String,
    manifest: Value,
}

#[test]
fn function_forms_pass_the_probes_on_real_drivers() {
    let package = package();
    let (gl, vulkan, hlsl) = (egl(), gpu(), hlsl());
    let mut runs = 0;
    for variant in variants(&package) {
        let probes = variant.probes();
        for egl in &gl {
            let got = variant.by_glsl(egl, &probes.directions);
            probes
                .check(&got)
                .unwrap_or_else(|e| panic!("{} {}: {e}", variant.folder, egl.route()));
            // an integrator's usual faults
            for (what, fault) in FAULTS {
                // a single period along x is its own mirror image
                if what == MIRRORED && variant.folder == "shaders/fingers/comparator" {
                    continue;
                }
                let wrong: Vec<_> = probes.directions.iter().copied().map(fault).collect();
                let seen = probes.check(&variant.by_glsl(egl, &wrong)).is_err();
                assert!(seen, "{} {}: {what} passes", variant.folder, egl.route());
            }
            runs += 1;
        }
        for gpu in &vulkan {
            let got = variant.by_wgsl(gpu, &probes.directions);
            probes
                .check(&got)
                .unwrap_or_else(|e| panic!("{} {}: {e}", variant.folder, gpu.route()));
            let black = vec![[[0.0; 3]; 2]; got.len()];
            assert!(probes.check(&black).is_err(), "{}: black passes", variant.folder);
            runs += 1;
        }
    }
    for driver in &hlsl {
        for variant in variants(&package) {
            let probes = variant.probes();
            let got = variant.by_hlsl(driver, &probes.directions);
            probes.check(&got).unwrap_or_else(|e| panic!("{} hlsl: {e}", variant.folder));
            let (_, wrong) = FAULTS[2];
            let wrong: Vec<Pair> = probes.directions.iter().copied().map(wrong).collect();
            assert!(probes.check(&variant.by_hlsl(driver, &wrong)).is_err(), "{}", variant.folder);
            runs += 1;
        }
    }
    println!("{runs} runs of function forms");
    let drivers = gl.len() + vulkan.len() + hlsl.len();
    assert!(runs >= 12 * drivers, "{runs} runs on {drivers} drivers");
}

fn package() -> Package {
    let plan = Plan::parse(PLAN, Path::new("plan.toml")).unwrap();
    let targets: Vec<Target> = Target::all().into_iter().collect();
    Compiler::new(&plan).targets(&targets).compile().unwrap_or_else(|errors| panic!("{errors}"))
}

fn egl() -> Vec<Egl> {
    Dialect::ALL.into_iter().filter_map(|dialect| found(Egl::open(dialect, None))).collect()
}

fn gpu() -> Vec<Gpu> {
    found(Gpu::open(Backend::Vulkan, None)).into_iter().collect()
}

fn hlsl() -> Vec<Passthrough> {
    found(Passthrough::open(Language::Hlsl, None)).into_iter().collect()
}

fn variants(package: &Package) -> Vec<Variant<'_>> {
    let paths = package.files().keys().filter(|path| path.starts_with("shaders/"));
    let manifests = paths.filter_map(|path| path.strip_suffix("/manifest.json"));
    let read = |folder: &str| Variant {
        package,
        folder: folder.to_owned(),
        manifest: json(package, &format!("{folder}/manifest.json")),
    };
    manifests.map(read).collect()
}

fn json(package: &Package, path: &str) -> Value {
    serde_json::from_slice(&package.files()[path].content.read().unwrap()).unwrap()
}

fn vector(value: &Value) -> [f64; 3] {
    std::array::from_fn(|i| value[i].as_f64().unwrap())
}

impl Probes {
    /// XYZ within the tolerance; RGB, whose matrix has rows of at most 5.3 in sum of moduli, within so much more.
    fn check(&self, got: &[Pair]) -> Result<(), String> {
        assert_eq!(got.len(), self.expected.len());
        for (i, (got, expected)) in got.iter().zip(&self.expected).enumerate() {
            for (what, kind) in [("XYZ", 0), ("RGB", 1)] {
                let allowed = self.tolerance[i] * if kind == 0 { 1.0 } else { 5.3 };
                let inside = |c: usize| (got[kind][c] - expected[kind][c]).abs() <= allowed;
                if !(0..3).all(inside) {
                    let (got, expected) = (got[kind], expected[kind]);
                    return Err(format!(
                        "probe {i}: {what} {got:?} for {expected:?} ± {allowed:e}"
                    ));
                }
            }
        }
        Ok(())
    }
}

impl Variant<'_> {
    fn probes(&self) -> Probes {
        let json = json(self.package, &format!("{}/probe.json", self.folder));
        let probes = json["probes"].as_array().unwrap();
        assert_eq!(probes.len(), 64);
        let pair = |a: &Value, b: &Value| [vector(a), vector(b)];
        Probes {
            directions: probes.iter().map(|p| pair(&p["wi"], &p["wr"])).collect(),
            expected: probes
                .iter()
                .map(|p| pair(&p["expected"]["xyz"], &p["expected"]["rgb"]))
                .collect(),
            tolerance: probes.iter().map(|p| p["tolerance"].as_f64().unwrap()).collect(),
        }
    }

    /// The function form of a target.
    fn text(&self, target: &str) -> String {
        let files = self.manifest["targets"][target].as_array().unwrap();
        let file = files.iter().find(|f| f["file"].as_str().unwrap().contains(".fn.")).unwrap();
        let path = format!("{}/{}", self.folder, file["file"].as_str().unwrap());
        String::from_utf8(self.package.files()[&path].content.read().unwrap().into_owned()).unwrap()
    }

    /// Names, bindings and contents of the tables, from their descriptions.
    fn tables(&self) -> Vec<(String, Table)> {
        let read = |table: &Value| {
            let path =
                |key: &str| table[key].as_str().unwrap().trim_start_matches("../").to_owned();
            let shape = json(self.package, &path("description"));
            let number = |key: &str| shape[key].as_u64().unwrap_or(0) as usize;
            let formats = [
                TexelFormat::Rg16Float,
                TexelFormat::Rgba16Float,
                TexelFormat::Rg32Float,
                TexelFormat::Rgba32Float,
            ];
            let format = formats.into_iter().find(|f| f.name() == shape["format"]).unwrap();
            let name = table["binding"].as_str().unwrap().to_owned();
            let bound = self.manifest["bindings"].as_array().unwrap();
            let binding = bound.iter().find(|b| b["name"] == name.as_str()).unwrap();
            let blank = Table {
                name: "table",
                binding: binding["binding"].as_u64().unwrap() as u32,
                format,
                width: number("width"),
                height: number("height"),
                layers: if shape["dimension"] == "2d-array" { number("layers") } else { 0 },
                filtered: false,
                texels: Vec::new(),
            };
            let bytes = self.package.files()[&path("data")].content.read().unwrap();
            (name, blank.with_bytes(&bytes))
        };
        self.manifest["tables"].as_array().unwrap().iter().map(read).collect()
    }

    /// XYZ and RGB of the pairs: `.fn.glsl` behind foreign code in one of the two dialects.
    fn by_glsl(&self, egl: &Egl, directions: &[Pair]) -> Vec<Pair> {
        let head = match egl.dialect() {
            Dialect::Glsl450 => "#version 450 core\n",
            Dialect::GlslEs300 => "#version 300 es\nprecision highp float;\nprecision highp int;\n",
        };
        let vertex = format!(
            r#"{head}void main() {{
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(corner, 0.0, 1.0);
}}
"#
        );
        let fragment = format!(
            r#"{head}{}
uniform highp sampler2D engine_directions;
uniform Engine {{ vec4 unused_light; vec4 opaque; }};
layout(location = 0) out vec4 colour;
void main() {{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 wi = texelFetch(engine_directions, ivec2(at.x, 0), 0).xyz;
    vec3 wr = texelFetch(engine_directions, ivec2(at.x, 1), 0).xyz;
    colour = vec4(at.y == 0 ? tristimulus(wi, wr) : diffraction(wi, wr), opaque.x);
}}
"#,
            self.text("glsl450")
        );
        let tables = self.tables();
        let table = listed(directions);
        let texture = |name: &str, binding: u32| bound(name, binding, BindingKind::Texture);
        let mut bindings: Vec<BindingName> =
            tables.iter().map(|(name, table)| texture(name, table.binding)).collect();
        bindings.push(texture("engine_directions", DIRECTIONS));
        bindings.push(bound("Engine", 0, BindingKind::UniformBlock));
        let target = egl.dialect().target();
        let file = |name: &str, text: String, stage, entry: &str, bindings| EmittedFile {
            name: name.to_owned(),
            target,
            bytes: text.into_bytes(),
            entry_points: vec![EntryPoint {
                stage,
                source_name: entry.to_owned(),
                emitted_name: "main".to_owned(),
            }],
            bindings,
            functions: Vec::new(),
        };
        let files = [
            file("engine.vert", vertex, Stage::Vertex, "vertex", Vec::new()),
            file("engine.frag", fragment, Stage::Fragment, "pixel", bindings),
        ];
        let mut uploads: Vec<(u32, &Table)> = tables.iter().map(|(_, t)| (t.binding, t)).collect();
        uploads.push((DIRECTIONS, &table));
        let pipeline = egl.compile(&self.folder, &files, "pixel", &uploads).unwrap();
        let size = [directions.len() as u32, 2];
        let params = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        // rows come from the top, so the first is RGB
        let picture = egl.draw(&pipeline, size, &params, &|_| ()).unwrap();
        pairs(&picture, directions.len(), [1, 0])
    }

    /// The same by `.fn.hlsl`, whose textures the engine puts on registers.
    fn by_hlsl(&self, driver: &Passthrough, directions: &[Pair]) -> Vec<Pair> {
        let (tables, listed) = (self.tables(), listed(directions));
        let mut text = self.text("hlsl");
        for (name, table) in &tables {
            let declared = format!(" {name};");
            assert_eq!(text.matches(&declared).count(), 1, "{text}");
            text = text.replace(&declared, &format!(" {name} : register(t{});", table.binding));
        }
        let text = format!(
            r#"{text}
Texture2D<float4> engine_directions : register(t{DIRECTIONS});
cbuffer Engine : register(b0) {{ float4 unused_light; float4 opaque; }}
float4 engine_vertex(uint i : SV_VertexID) : SV_Position {{
    return float4(float(i & 1u) * 4.0 - 1.0, float(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}}
float4 engine_pixel(float4 place : SV_Position) : SV_Target0 {{
    int2 at = int2(place.xy);
    float3 wi = engine_directions.Load(int3(at.x, 0, 0)).xyz;
    float3 wr = engine_directions.Load(int3(at.x, 1, 0)).xyz;
    if (at.y == 0) {{ return float4(tristimulus(wi, wr), opaque.x); }}
    return float4(diffraction(wi, wr), opaque.x);
}}
"#
        );
        let point = |stage, name: &str| EntryPoint {
            stage,
            source_name: name.to_owned(),
            emitted_name: name.to_owned(),
        };
        let mut bindings: Vec<BindingName> =
            tables.iter().map(|(n, t)| bound(n, t.binding, BindingKind::Texture)).collect();
        bindings.push(bound("engine_directions", DIRECTIONS, BindingKind::Texture));
        bindings.push(bound("Engine", 0, BindingKind::UniformBlock));
        let file = EmittedFile {
            name: "engine.hlsl".to_owned(),
            target: Target::Hlsl,
            bytes: text.into_bytes(),
            entry_points: vec![
                point(Stage::Vertex, "engine_vertex"),
                point(Stage::Fragment, "engine_pixel"),
            ],
            bindings,
            functions: Vec::new(),
        };
        let mut uploads: Vec<(u32, &Table)> = tables.iter().map(|(_, t)| (t.binding, t)).collect();
        uploads.push((DIRECTIONS, &listed));
        let pipeline = driver.compile(&self.folder, &[file], "engine_pixel", &uploads).unwrap();
        let params = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        let picture =
            driver.draw(&pipeline, [directions.len() as u32, 2], &params, &|_| ()).unwrap();
        pairs(&picture, directions.len(), [0, 1])
    }

    /// The same by `.fn.wgsl`, whose textures are parameters.
    fn by_wgsl(&self, gpu: &Gpu, directions: &[Pair]) -> Vec<Pair> {
        let text = self.text("wgsl");
        let tables = self.tables();
        let call = |function: &str| {
            let begin = format!("fn {function}(");
            let line = text.lines().find_map(|l| l.strip_prefix(begin.as_str())).unwrap();
            let parameters = line.split_once(')').unwrap().0.split(", ");
            let names: Vec<&str> = parameters.map(|p| p.split_once(':').unwrap().0).collect();
            assert_eq!(names[..2], ["wi", "wr"]);
            let own: Vec<String> = names[2..].iter().map(|n| format!("engine_{n}")).collect();
            format!("{function}({})", [vec!["wi".into(), "wr".into()], own].concat().join(", "))
        };
        let variables: String = tables
            .iter()
            .map(|(name, t)| {
                let kind = if t.layers > 0 { "texture_2d_array" } else { "texture_2d" };
                format!("@group(0) @binding({}) var engine_{name}: {kind}<f32>;\n", t.binding)
            })
            .collect();
        let wgsl = format!(
            r#"{text}
{variables}@group(0) @binding({DIRECTIONS}) var engine_directions: texture_2d<f32>;
@group(0) @binding(0) var<uniform> opaque: vec4f;
@vertex fn engine_vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {{
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}}
@fragment fn engine_pixel(@builtin(position) place: vec4f) -> @location(0) vec4f {{
    let at = vec2i(place.xy);
    let wi = textureLoad(engine_directions, vec2i(at.x, 0), 0).xyz;
    let wr = textureLoad(engine_directions, vec2i(at.x, 1), 0).xyz;
    if (at.y == 0) {{ return vec4f({}, opaque.x); }}
    return vec4f({}, opaque.x);
}}
"#,
            call("tristimulus"),
            call("diffraction")
        );
        let listed = listed(directions);
        let mut textures: Vec<Texture<'_>> = tables.iter().map(|(_, t)| texture(t)).collect();
        textures.push(texture(&listed));
        let program = Program {
            name: &self.folder,
            shader: Shader::Wgsl(&wgsl),
            vertex_entry: "engine_vertex",
            fragment_entry: "engine_pixel",
            textures,
            uniform: Some(Uniform { binding: 0, size: 16 }),
        };
        let pipeline = gpu.program(&program).unwrap();
        let opaque = 1.0_f32.to_le_bytes().repeat(4);
        let picture = pipeline.render(directions.len() as u32, 2, &opaque).unwrap();
        pairs(&picture, directions.len(), [0, 1])
    }
}

fn bound(name: &str, binding: u32, kind: BindingKind) -> BindingName {
    BindingName {
        source_name: name.to_owned(),
        emitted_name: name.to_owned(),
        member_name: None,
        group: 0,
        binding,
        emitted_binding: None,
        kind,
    }
}

/// Row 0 holds directions to the light, row 1 those to the viewer.
fn listed(directions: &[Pair]) -> Table {
    let row = |which: usize| directions.iter().flat_map(move |d| [d[which].to_vec(), vec![0.0]]);
    Table {
        name: "directions",
        binding: DIRECTIONS,
        format: TexelFormat::Rgba32Float,
        width: directions.len(),
        height: 2,
        layers: 0,
        filtered: false,
        texels: row(0).chain(row(1)).flatten().collect(),
    }
}

fn texture(table: &Table) -> Texture<'static> {
    Texture {
        binding: table.binding,
        layout: if table.layers > 0 { TextureLayout::D2Array } else { TextureLayout::D2 },
        format: match table.format {
            TexelFormat::Rg16Float => TextureFormat::Rg16Float,
            TexelFormat::Rgba16Float => TextureFormat::Rgba16Float,
            TexelFormat::Rg32Float => TextureFormat::Rg32Float,
            TexelFormat::Rgba32Float => TextureFormat::Rgba32Float,
            TexelFormat::Rgb9e5Ufloat => TextureFormat::Rgb9e5Ufloat,
        },
        width: table.width as u32,
        height: table.height as u32,
        layers: table.layers.max(1) as u32,
        sampler: None,
        bytes: Cow::Owned(table.bytes()),
    }
}

/// XYZ and RGB of each pair from the two rows of a picture.
fn pairs(picture: &[[f32; 4]], count: usize, rows: [usize; 2]) -> Vec<Pair> {
    let colour = |row: usize, i: usize| {
        let [x, y, z, opaque] = picture[row * count + i].map(f64::from);
        assert_eq!(opaque, 1.0);
        [x, y, z]
    };
    (0..count).map(|i| rows.map(|row| colour(row, i))).collect()
}
