//! Proves an integration: evaluates the probes of a package's variant by the code of the example `wgpu`.
//!
//!     cargo run --release -p diffraction-harness --example wgpu_probe -- generated/shaders/fingers/full-taylor-t19
//!
//! Prints JSON. `worst` is the greatest error over the tolerance of its direction; `controls` are the
//! same for integrations that are wrong on purpose, and must be far above 1.

use std::{env, error::Error, fs, path::Path};

use serde::Deserialize;
use serde_json::{Value, json};

#[path = "wgpu.rs"]
#[allow(dead_code, reason = "it draws, too")]
pub mod draw;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Directions come in, XYZ and RGB go out; of 64 pairs at once.
const PROBE: &str = "
@group(1) @binding(0) var<storage, read_write> pairs: array<array<vec4f, 2>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < arrayLength(&pairs)) {
        let wi = pairs[id.x][0].xyz;
        let wr = pairs[id.x][1].xyz;
        pairs[id.x][0] = vec4f(tristimulus(wi, wr), 0.0);
        pairs[id.x][1] = vec4f(diffraction(wi, wr), 0.0);
    }
}";
/// RGB may be wrong by as much more than XYZ: the greatest sum of moduli of a row of its matrix.
const RGB: f64 = 5.3;

#[derive(Deserialize)]
struct Probes {
    probes: Vec<Probe>,
}

#[derive(Deserialize)]
struct Probe {
    wi: [f32; 3],
    wr: [f32; 3],
    expected: Expected,
    tolerance: f64,
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

/// How far the variant in a folder is off.
pub fn run(gpu: &(wgpu::Device, wgpu::Queue), folder: &Path) -> Result<Value> {
    let Probes { probes } = serde_json::from_slice(&fs::read(folder.join("probe.json"))?)?;
    let evaluate = |sign: f32| -> Result<Vec<[[f32; 4]; 2]>> {
        let texel = |[x, y, z]: [f32; 3]| [x, sign * y, z, 0.0];
        let pairs: Vec<_> = probes.iter().map(|p| [texel(p.wi), texel(p.wr)]).collect();
        let workgroups = pairs.len().div_ceil(64) as u32;
        let bytes = draw::run(gpu, folder, PROBE, workgroups, bytemuck::cast_slice(&pairs))?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    };
    let (seen, flipped) = (evaluate(1.0)?, evaluate(-1.0)?);
    let info = gpu.0.adapter_info();
    let names = folder.iter().rev().map(|part| part.to_string_lossy()).collect::<Vec<_>>();
    Ok(json!({
        "driver": format!("{} {}", info.backend, info.name),
        "surface": names[1], "variant": names[0], "count": probes.len(),
        "worst": worst(&seen, &probes, [0, 1, 2]),
        "controls": {
            "swapped channels": worst(&seen, &probes, [2, 1, 0]),
            "flipped bitangent": worst(&flipped, &probes, [0, 1, 2]),
        },
    }))
}

/// The greatest error over what is allowed, of channels read in an order; no number is quite wrong.
fn worst(seen: &[[[f32; 4]; 2]], probes: &[Probe], order: [usize; 3]) -> f64 {
    let ratios = seen.iter().zip(probes).flat_map(|([xyz, rgb], probe)| {
        let allowed = probe.tolerance;
        let ratio = move |seen: &[f32; 4], expected: [f64; 3], allowed: f64| {
            [0, 1, 2].map(|c| (f64::from(seen[order[c]]) - expected[c]).abs() / allowed)
        };
        let xyz = ratio(xyz, probe.expected.xyz, allowed);
        xyz.into_iter().chain(ratio(rgb, probe.expected.rgb, RGB * allowed))
    });
    ratios.map(|ratio| if ratio.is_finite() { ratio } else { f64::MAX }).fold(0.0, f64::max)
}
