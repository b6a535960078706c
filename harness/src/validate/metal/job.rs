//! From a package's manifest and probes to a program that evaluates them by the Metal text, and the verdict on its results.
//!
//! Each probe is evaluated three times: XYZ by the entry point `probe`, RGB by the function `diffraction`, and RGB by the
//! entry points of meshes, in tangent frames of both hands, turned and mirrored.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use diffraction_shaders::input::read_file;
use diffraction_shaders::package::MAX_MANIFEST_BYTES;
use glam::DVec3;
use serde_json::Value;

use super::block::Block;
use super::frame::Frame;
use super::main_text::{Bindings, main_text};

/// RGB may be wrong by so much more than XYZ: the greatest sum of moduli of a row of the matrix from XYZ to RGB.
const RGB: f64 = 5.3;

/// A program, its data, and what its results must be.
pub(super) struct Job {
    /// The C++ text of the main function.
    pub main: String,
    /// What the program reads.
    pub data: String,
    probes: Vec<Expected>,
    mesh: bool,
}

struct Expected {
    xyz: DVec3,
    /// `None` for functions of lights with a size, which only the entry point `probe` calls.
    rgb: Option<DVec3>,
    /// Whether the mesh has the probe's pattern.
    is_on_mesh: bool,
    tolerance: f64,
}

/// The function whose probes have surroundings.
const AROUND: &str = "diffraction_environment";

/// The function whose probes are paths.
const PATH: &str = "diffraction_path";

/// Whether a probe is evaluated: of those among surroundings, the ones under a sky of radiance 1 everywhere, which is one texel.
fn is_evaluated(probe: &Value) -> bool {
    let sky = &probe["sky"];
    let is_white = sky["constant"] == serde_json::json!([1.0, 1.0, 1.0]);
    probe["function"] != AROUND || is_white && sky["lobes"].as_array().is_some_and(Vec::is_empty)
}

/// The pattern of a probe; zero without.
fn pattern(probe: &Value) -> [f64; 4] {
    [0, 1, 2, 3].map(|i| probe["pattern"][i].as_f64().unwrap_or_default())
}

/// The arguments of a probe as rows of texels, as the template `probe` reads them.
fn arguments(probe: &Value) -> Vec<[f64; 4]> {
    let row = |value: &Value, w: f64| {
        let v = vector(value);
        [v.x, v.y, v.z, w]
    };
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let colour = [0, 1, 2].map(|i| &probe["colour"][i]).map(number);
    match probe["function"].as_str() {
        None => vec![row(&probe["wi"], 0.0), row(&probe["wr"], 0.0)],
        Some("diffraction_spread") => {
            vec![row(&probe["wi"], 9.0), row(&probe["wr"], number(&probe["spread"]))]
        }
        Some("diffraction_disc") => {
            vec![row(&probe["axis"], 1.0), row(&probe["wr"], number(&probe["radius"]))]
        }
        Some(PATH) => {
            let (sky, lobe) = (&probe["sky"], &probe["sky"]["lobes"][0]);
            vec![
                row(&sky["constant"], 8.0),
                row(&probe["wr"], number(&lobe["sigma"])),
                row(&lobe["axis"], 0.0),
                row(&lobe["radiance"], 0.0),
                row(&probe["random"], 0.0),
            ]
        }
        Some("diffraction_disc_coloured") => {
            let axis = |w| row(&probe["axis"], w);
            let viewer = row(&probe["wr"], number(&probe["radius"]));
            [axis(4.0), viewer].into_iter().chain(colour.map(axis)).collect()
        }
        Some(AROUND) => vec![row(&probe["wr"], 3.0), row(&probe["wr"], 0.0)],
        Some(function) => {
            let corners = [0, 1, 2, 3].map(|i| &probe["corners"][i]);
            let is_coloured = function == "diffraction_rectangle_coloured";
            let (number, colour) = if is_coloured { (5.0, colour) } else { (2.0, [0.0; 3]) };
            let others = corners[1..].iter().zip(colour).map(|(corner, w)| row(corner, w));
            [row(corners[0], number), row(&probe["wr"], 0.0)].into_iter().chain(others).collect()
        }
    }
}

impl Job {
    /// Reads the manifest and the probes beside a text. `folder` gets the textures that are not the package's.
    pub(super) fn read(file: &Path, text: &str, folder: &Path) -> Result<Job, String> {
        let manifest = json(&file.with_file_name("manifest.json"))?;
        let probes = json(&file.with_file_name("probe.json"))?;
        let all = |key: &str| probes[key].as_array().into_iter().flatten();
        if all("probes").next().is_none() {
            return Err("probe.json: has no probes".to_owned());
        }
        let probes: Vec<&Value> =
            all("probes").chain(all("lights")).filter(|probe| is_evaluated(probe)).collect();
        let has_around = probes.iter().any(|probe| probe["function"] == AROUND);
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let targets = manifest["targets"]["msl"].as_array().map_or(&[][..], Vec::as_slice);
        let target = targets.iter().find(|target| target["file"] == *name);
        let target = target.ok_or_else(|| format!("the manifest lists no Metal file `{name}`"))?;
        let entries = target["entry_points"].as_array().map_or(&[][..], Vec::as_slice);
        let entry = |source: &str| {
            let found = entries.iter().find(|entry| entry["source_name"] == source)?;
            found["emitted_name"].as_str()
        };
        let probe = entry("probe").ok_or("the manifest lists no entry point `probe`")?;
        let mesh = entry("mesh_vert").zip(entry("mesh"));
        let bindings = Bindings(target);
        let has_pattern = probes.iter().any(|probe| probe["pattern"].is_array());
        let main = main_text(text, probe, mesh, &bindings, has_pattern)?;

        let (mut data, mut textures) = (String::new(), 0);
        let mut texture =
            |number: usize, channels: u64, size: [u64; 3], binding: u64, file: &Path| {
                textures += 1;
                let [width, height, layers] = size;
                let file = file.display();
                let _ = writeln!(
                    data,
                    "{binding} {number} {channels} {width} {height} {layers} {file}"
                );
            };
        for table in manifest["tables"].as_array().into_iter().flatten() {
            let place = |key: &str| file.with_file_name(table[key].as_str().unwrap_or_default());
            let description = json(&place("description"))?;
            let format = description["format"].as_str().unwrap_or_default();
            let (number, channels) = match format {
                "rg32float" => (0, 2),
                "rgba32float" => (0, 4),
                "rg16float" => (1, 2),
                "rgba16float" => (1, 4),
                "rgb9e5ufloat" => (2, 3),
                other => return Err(format!("a table has the unknown format `{other}`")),
            };
            let size =
                ["width", "height", "layers"].map(|key| description[key].as_u64().unwrap_or(1));
            let binding = bindings.number(table["binding"].as_str().unwrap_or_default())?;
            let data = fs::canonicalize(place("data"))
                .map_err(|error| format!("{}: {error}", place("data").display()))?;
            texture(number, channels, size, binding, &data);
        }
        // two rows, directions to the light and to the viewer; five with functions of lights with a size; six with a pattern
        let count = probes.len() as u64;
        let height = match manifest["functions"].is_array() {
            _ if has_pattern => 6,
            true => 5,
            false => 2,
        };
        let column = |probe: &&Value| {
            let mut column = arguments(probe);
            if has_pattern {
                column.resize(5, [0.0; 4]);
                column.push(pattern(probe));
            }
            column
        };
        let columns: Vec<Vec<[f64; 4]>> = probes.iter().map(column).collect();
        let texel =
            |row: usize, column: &Vec<[f64; 4]>| column.get(row).copied().unwrap_or_default();
        let rows = (0..height).flat_map(|row| columns.iter().map(move |column| texel(row, column)));
        let texels = rows.flatten();
        let directions = folder.join("directions");
        floats(&directions, texels)?;
        texture(0, 4, [count, height as u64, 1], bindings.number("directions")?, &directions);
        if has_around {
            // a sky of radiance 1
            let sky = folder.join("environment");
            floats(&sky, [1.0; 4])?;
            texture(0, 4, [1, 1, 1], bindings.number("environment")?, &sky);
        }
        let mesh_block = Block::of(&manifest, "mesh_params");
        if mesh.is_some() {
            // a map of one texel: the frame is not turned further, and the pattern is that of the first probe
            let map = folder.join("orientation_map");
            let [_, _, period, depth] = pattern(probes[0]);
            floats(&map, [0.0, period, depth, 1.0])?;
            texture(0, 4, [1, 1, 1], bindings.number("orientation_map")?, &map);
        }
        let mut data = format!("{textures}\n{data}");
        let params =
            Block::of(&manifest, "params").ok_or("the manifest has no uniforms `params`")?;
        let params = params.floats(&[("size", &[count as f64, 1.0, 0.0, 0.0])]);
        let _ = writeln!(data, "{} {} {}", bindings.number("params")?, params.len(), line(&params));
        let size = mesh_block.as_ref().map_or(0, |block| block.size);
        let _ = writeln!(data, "{count} {size}");
        for (index, probe) in probes.iter().enumerate() {
            // of a light with a size, any direction of it
            let wi =
                columns[index].first().map_or(DVec3::Z, |row| DVec3::new(row[0], row[1], row[2]));
            let wr = vector(&probe["wr"]);
            let frame = Frame::number(index);
            let mut numbers = [wi, wr, frame.normal, frame.tangent].map(|v| v.to_array()).concat();
            numbers.extend([frame.hand, frame.angle]);
            numbers.extend(pattern(probe));
            if let Some(block) = &mesh_block {
                numbers.extend(frame.uniforms(block, wi, wr));
            }
            data += &line(&numbers);
            data.push('\n');
        }
        let expected = probes.iter().map(|probe| Expected {
            xyz: vector(&probe["expected"]["xyz"]),
            rgb: probe["function"].is_null().then(|| vector(&probe["expected"]["rgb"])),
            is_on_mesh: probe["pattern"] == probes[0]["pattern"],
            tolerance: probe["tolerance"].as_f64().unwrap_or_default(),
        });
        Ok(Job { main, data, probes: expected.collect(), mesh: mesh.is_some() })
    }

    /// The greatest error of the printed results in tolerances; an error if one is beyond its tolerance.
    pub(super) fn worst(&self, printed: &str) -> Result<f64, String> {
        let lines: Vec<&str> = printed.lines().filter(|line| !line.trim().is_empty()).collect();
        if lines.len() != self.probes.len() {
            return Err(format!(
                "printed {} results for {} probes",
                lines.len(),
                self.probes.len()
            ));
        }
        let mut worst = 0.0;
        for (index, (line, probe)) in lines.iter().zip(&self.probes).enumerate() {
            let mut numbers = line.split_whitespace().map(|word| word.parse().unwrap_or(f64::NAN));
            let mut three =
                || DVec3::from_array([(); 3].map(|()| numbers.next().unwrap_or(f64::NAN)));
            let mut compared = vec![("XYZ of the entry point probe", three(), probe.xyz, 1.0)];
            if let Some(rgb) = probe.rgb {
                compared.push(("RGB of diffraction()", three(), rgb, RGB));
                if self.mesh {
                    let on_mesh = three();
                    if probe.is_on_mesh {
                        compared.push(("RGB of the entry point mesh", on_mesh, rgb, RGB));
                    }
                }
            }
            for (what, found, expected, factor) in compared {
                let difference = found - expected;
                let error = difference.abs().max_element() / (factor * probe.tolerance);
                if error > 1.0 || error.is_nan() || difference.is_nan() {
                    return Err(format!(
                        "probe {index}: {what} is {found}, expected {expected}: {error:.3} tolerances"
                    ));
                }
                worst = f64::max(worst, error);
            }
        }
        Ok(worst)
    }
}

fn json(file: &Path) -> Result<Value, String> {
    let name = file.display();
    let text = read_file(file, MAX_MANIFEST_BYTES).map_err(|error| format!("{name}: {error}"))?;
    serde_json::from_slice(&text).map_err(|error| format!("{name}: is not valid JSON: {error}"))
}

/// Three numbers; not a number where the file has something else.
fn vector(value: &Value) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|i| value[i].as_f64().unwrap_or(f64::NAN)))
}

/// Writes numbers as little-endian 32-bit floats.
fn floats(file: &Path, numbers: impl IntoIterator<Item = f64>) -> Result<(), String> {
    let bytes = numbers.into_iter().flat_map(|number| (number as f32).to_le_bytes());
    fs::write(file, bytes.collect::<Vec<u8>>()).map_err(|error| error.to_string())
}

/// Numbers as 32-bit floats, in one line.
fn line(numbers: &[f64]) -> String {
    let words: Vec<String> = numbers.iter().map(|number| (*number as f32).to_string()).collect();
    words.join(" ")
}
