//! What several tests need.

use std::collections::BTreeSet;
use std::fs;

use diffraction_shaders::Compiler;
use diffraction_shaders::diagnostic::Diagnostic;
use diffraction_shaders::input;
use diffraction_shaders::package::Package;
use diffraction_shaders::plan::Target;
use diffraction_shaders::shader::emit::{EmittedFile, emit};
use diffraction_shaders::shader::module::{Module, compile};
use diffraction_shaders::shader::template::{Defines, Sources, Specialised, specialise};

/// Every target.
pub const TARGETS: [Target; 6] =
    [Target::Wgsl, Target::Glsl450, Target::GlslEs300, Target::Spirv, Target::Hlsl, Target::Msl];

/// The root of the small test shader, with resources like those of the shipped ones.
pub const ROOT: &str = r#"// A small shader with the resources of the real ones.
struct Params {
    scale: vec4f,
    gain: vec4f,
}
@group(0) @binding(0) var<uniform> params: Params;
// Transforms, one layer each.
@group(0) @binding(1) var terms: texture_2d_array<f32>;
@group(0) @binding(2) var spectrum: texture_2d<f32>;

#constants
#import core

struct VertexOutput {
    @builtin(position) position: vec4f,
    @location(0) place: vec2f,
}

@vertex
fn vert(@builtin(vertex_index) index: u32) -> VertexOutput {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    var out: VertexOutput;
    out.place = corner * 2.0 - 1.0;
    out.position = vec4f(out.place, 0.0, 1.0);
    return out;
}

@fragment
fn map(@location(0) place: vec2f) -> @location(0) vec4f {
    let wr = vec3f(place, sqrt(max(0.0, 1.0 - dot(place, place))));
    return vec4f(diffraction(vec3f(0.0, 0.0, 1.0), wr) * params.gain.xyz, 1.0);
}

#import probe
"#;

/// The core function of the test shader.
pub const CORE: &str = r#"fn diffraction(wi: vec3f, wr: vec3f) -> vec3f {
    return tristimulus(wi, wr) * SCALE;
}

// Sums all terms over all wavelengths.
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    let size = vec2i(textureDimensions(terms));
    let h = wi + wr;
    let texel = (vec2i(floor(h.xy * 3.0)) % size + size) % size;
    var sum = vec3f(0.0);
    for (var w = 0; w < WAVELENGTHS; w += 1) {
        let weight = textureLoad(spectrum, vec2i(w, 0), 0);
        var amplitude = vec2f(0.0);
        var power = 1.0;
        for (var t = 0; t < TERMS; t += 1) {
            let term = textureLoad(terms, texel, t, 0);
#ifdef PAIRED
            amplitude += power * (term.xy + h.z * term.zw);
#else
            amplitude += power * term.xy;
#endif
            power *= h.z * weight.w;
        }
        sum += weight.xyz * dot(amplitude, amplitude);
    }
    return sum;
}
"#;

/// The second fragment shader of the test shader.
pub const PROBE: &str = r#"@group(0) @binding(3) var directions: texture_2d<f32>;

@fragment
fn probe(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let row = i32(position.y);
    let wi = textureLoad(directions, vec2i(0, row), 0).xyz;
    let wr = textureLoad(directions, vec2i(1, row), 0).xyz;
    return vec4f(diffraction(wi, wr) * params.gain.xyz, 1.0);
}
"#;

/// Templates of the test shader.
pub fn sources() -> Sources {
    [("root", ROOT), ("core", CORE), ("probe", PROBE)].into_iter().collect()
}

/// Flags and constants of the test shader.
pub fn defines() -> Defines {
    let mut defines = Defines::default();
    defines.flag("PAIRED", true);
    defines.count("WAVELENGTHS", 81, "number of wavelengths");
    defines.count("TERMS", 31, "number of terms");
    defines.number("SCALE", 0.1, "factor of the result");
    defines
}

/// The specialised test shader.
pub fn specialised() -> Specialised {
    specialise(&sources(), "root", &defines()).unwrap_or_else(|errors| panic!("{errors:#?}"))
}

/// The compiled test shader.
pub fn module() -> Module {
    compile(&specialised(), &sources(), "test").unwrap_or_else(|errors| panic!("{errors:#?}"))
}

/// All files of all targets of the test shader; the function form of GLSL once, as of its first target.
pub fn files() -> Vec<EmittedFile> {
    let module = module();
    let mut names = BTreeSet::new();
    let files = TARGETS.into_iter().flat_map(|target| emit(&module, target).unwrap());
    files.filter(|file| names.insert(file.name.clone())).collect()
}

/// Where [`package`] holds its shaders.
pub const VARIANT_FOLDER: &str = "shaders/tiny/full-taylor-t3";

/// A generated package of one small surface and two variants.
pub fn package() -> Package {
    package_in(&TARGETS)
}

/// The same in these languages.
pub fn package_in(targets: &[Target]) -> Package {
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.toml");
    let text = r#"schema = 1
[[surface]]
name = "tiny"
grating = { kind = "blazed", period_um = 1.0, height_um = 0.02, pixels = 16 }
[variants]
mode = ["full"]
terms = [3]
[[preset]]
name = "one"
mode = "full"
terms = 2
packing = "single"
hoist = false
"#;
    fs::write(&plan, text).unwrap();
    let plan = input::read_plan(&plan).unwrap_or_else(|errors| panic!("{errors:#?}"));
    let compiler = Compiler::new(&plan).targets(targets);
    compiler.compile().unwrap_or_else(|errors| panic!("{errors}"))
}

/// `file:line:column: message` of every diagnostic.
pub fn lines(diagnostics: &[Diagnostic]) -> Vec<String> {
    let describe = |diagnostic: &Diagnostic| match &diagnostic.primary {
        Some(p) => format!("{}:{}:{}: {}", p.file, p.line, p.column, diagnostic.message),
        None => diagnostic.message.clone(),
    };
    diagnostics.iter().map(describe).collect()
}
