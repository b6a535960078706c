//! Proves an integration: evaluates the probes of a package's variant by the code of the example `wgpu`.
//!
//!     cargo run --release -p diffraction-harness --example wgpu_probe -- generated/shaders/fingers/full-taylor-t19
//!
//! Prints JSON. `worst` is the greatest error over the tolerance of its probe; `controls` are the same for
//! integrations that are wrong on purpose, of the function that shows it least, and must be far above 1.

use std::{collections::BTreeMap, env, error::Error, fs, path::Path};

use serde::Deserialize;
use serde_json::{Value, json};

#[path = "wgpu.rs"]
#[allow(dead_code, reason = "it draws, too")]
pub mod draw;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Arguments come in, the number of a function in w of the first; XYZ and RGB go out in their place.
const PROBE: &str = "
struct Probe { first: vec4f, viewer: vec4f, second: vec4f, third: vec4f, fourth: vec4f }

@group(1) @binding(0) var<storage, read_write> probes: array<Probe>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&probes)) {
        return;
    }
    let a = probes[id.x].first.xyz;
    let b = probes[id.x].second.xyz;
    let c = probes[id.x].third.xyz;
    let d = probes[id.x].fourth.xyz;
    let radius = probes[id.x].viewer.w;
    let colour = vec3f(probes[id.x].second.w, probes[id.x].third.w, probes[id.x].fourth.w);
    let wr = probes[id.x].viewer.xyz;
    var xyz = vec3f(0.0);
    var rgb = vec3f(0.0);
    switch (i32(probes[id.x].first.w)) {
        CASES
        default: {}
    }
    probes[id.x].first = vec4f(xyz, 0.0);
    probes[id.x].viewer = vec4f(rgb, 0.0);
}";
/// Functions of the variants with their arguments above.
const FUNCTIONS: [(&str, &str); 6] = [
    ("diffraction", "a, wr"),
    ("diffraction_disc", "a, radius, wr"),
    ("diffraction_spread", "a, wr, radius"),
    ("diffraction_rectangle", "a, b, c, d, wr"),
    ("diffraction_disc_coloured", "a, radius, colour, wr"),
    ("diffraction_rectangle_coloured", "a, b, c, d, colour, wr"),
];
/// The function whose surroundings are the host's in function forms.
const AROUND: &str = "diffraction_environment";
/// RGB may be wrong by as much more than XYZ: the greatest sum of moduli of a row of its matrix.
const RGB: f64 = 5.3;

#[derive(Deserialize)]
struct Probes {
    probes: Vec<Probe>,
    #[serde(default)]
    lights: Vec<Probe>,
}

/// A probe of a single direction, or of a light with a size.
#[derive(Deserialize)]
struct Probe {
    function: Option<String>,
    wi: Option<[f32; 3]>,
    axis: Option<[f32; 3]>,
    radius: Option<f32>,
    spread: Option<f32>,
    corners: Option<[[f32; 3]; 4]>,
    colour: Option<[f32; 3]>,
    wr: [f32; 3],
    expected: Expected,
    tolerance: f64,
}

impl Probe {
    fn function(&self) -> &str {
        self.function.as_deref().unwrap_or("diffraction")
    }
}

#[derive(Deserialize)]
struct Expected {
    xyz: [f64; 3],
    rgb: [f64; 3],
}

fn main() -> Result<()> {
    let folder = env::args().nth(1).ok_or("usage: wgpu_probe FOLDER")?;
    println!("{}", run(&draw::connect()?, Path::new(&folder))?);
    Ok(())
}

/// How an integration may be wrong.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    None,
    FlippedBitangent,
    /// A disc of another radius, lobes of another spread, a quadrilateral without its last corner.
    AnotherSize,
}

/// How far the variant in a folder is off.
pub fn run(gpu: &(wgpu::Device, wgpu::Queue), folder: &Path) -> Result<Value> {
    let Probes { mut probes, lights } =
        serde_json::from_slice(&fs::read(folder.join("probe.json"))?)?;
    // whole shaders have surroundings of their own, not the skies of probes
    probes.extend(lights.into_iter().filter(|probe| probe.function() != AROUND));
    let mut functions = BTreeMap::new();
    for probe in &probes {
        *functions.entry(probe.function()).or_insert(0) += 1;
    }
    let cases = (0..).zip(FUNCTIONS).filter(|(_, (name, _))| functions.contains_key(name));
    let cases = cases.map(|(case, (name, arguments))| {
        let tristimulus = name.replace("diffraction", "tristimulus");
        format!("case {case}: {{ xyz = {tristimulus}({arguments}); rgb = {name}({arguments}); }}\n")
    });
    let entry_point = PROBE.replace("CASES", &cases.collect::<String>());
    let evaluate = |fault: Fault| -> Result<Vec<[[f32; 4]; 2]>> {
        let texels: Result<Vec<_>> = probes.iter().map(|probe| arguments(probe, fault)).collect();
        let workgroups = probes.len().div_ceil(64) as u32;
        let texels = bytemuck::cast_slice(texels?.as_flattened()).to_vec();
        let bytes = draw::run(gpu, folder, &entry_point, workgroups, &texels)?;
        let results: Vec<[[f32; 4]; 5]> = bytemuck::pod_collect_to_vec(&bytes);
        Ok(results.iter().map(|[xyz, rgb, ..]| [*xyz, *rgb]).collect())
    };
    let [seen, flipped, resized] =
        [evaluate(Fault::None)?, evaluate(Fault::FlippedBitangent)?, evaluate(Fault::AnotherSize)?];
    let off = |seen: &[[[f32; 4]; 2]], function: &str, order: [usize; 3]| {
        let pairs = seen.iter().zip(&probes).filter(|(_, probe)| probe.function() == function);
        worst(pairs, order)
    };
    // each function must show a fault
    let least = |seen: &[[[f32; 4]; 2]], order: [usize; 3], lights_only: bool| {
        let names = functions.keys().filter(|name| !lights_only || **name != "diffraction");
        names.map(|name| off(seen, name, order)).fold(f64::MAX, f64::min)
    };
    let mut controls = json!({
        "swapped channels": least(&seen, [2, 1, 0], false),
        "flipped bitangent": least(&flipped, [0, 1, 2], false),
    });
    if functions.len() > 1 {
        controls["another size of the light"] = least(&resized, [0, 1, 2], true).into();
    }
    let info = gpu.0.adapter_info();
    let names = folder.iter().rev().map(|part| part.to_string_lossy()).collect::<Vec<_>>();
    Ok(json!({
        "driver": format!("{} {}", info.backend, info.name),
        "surface": names[1], "variant": names[0], "count": probes.len(), "functions": functions,
        "worst": functions.keys().map(|name| off(&seen, name, [0, 1, 2])).fold(0.0, f64::max),
        "controls": controls,
    }))
}

/// Arguments of a probe's function as the entry point reads them.
fn arguments(probe: &Probe, fault: Fault) -> Result<[[f32; 4]; 5]> {
    let known = FUNCTIONS.iter().position(|(name, _)| *name == probe.function());
    let number = known.ok_or_else(|| format!("{}: not a known function", probe.function()))?;
    let first = probe.wi.or(probe.axis).unwrap_or_default();
    let [a, b, c, mut d] = probe.corners.unwrap_or([first; 4]);
    let mut radius = probe.radius.or(probe.spread).unwrap_or_default();
    if fault == Fault::AnotherSize {
        (radius, d) = (1.5 * radius, c);
    }
    let colour = probe.colour.unwrap_or_default();
    let sign = if fault == Fault::FlippedBitangent { -1.0 } else { 1.0 };
    let texel = |[x, y, z]: [f32; 3], w: f32| [x, sign * y, z, w];
    Ok([
        texel(a, number as f32),
        texel(probe.wr, radius),
        texel(b, colour[0]),
        texel(c, colour[1]),
        texel(d, colour[2]),
    ])
}

/// The greatest error over what is allowed, of channels read in an order; no number is quite wrong.
fn worst<'a>(
    pairs: impl Iterator<Item = (&'a [[f32; 4]; 2], &'a Probe)>,
    order: [usize; 3],
) -> f64 {
    let ratios = pairs.flat_map(|([xyz, rgb], probe)| {
        let allowed = probe.tolerance;
        let ratio = move |seen: &[f32; 4], expected: [f64; 3], allowed: f64| {
            [0, 1, 2].map(|c| (f64::from(seen[order[c]]) - expected[c]).abs() / allowed)
        };
        let xyz = ratio(xyz, probe.expected.xyz, allowed);
        xyz.into_iter().chain(ratio(rgb, probe.expected.rgb, RGB * allowed))
    });
    ratios.map(|ratio| if ratio.is_finite() { ratio } else { f64::MAX }).fold(0.0, f64::max)
}
