//! `cargo xtask material`: the keys of a plan for a material of a glTF file.

mod keys;
mod metal;
mod read;

use std::path::{Path, PathBuf};

use anyhow::Result;
use diffraction_shaders::error::Error;
use serde_json::{Value, json};

use crate::Outcome;
use crate::console::{Console, Errors, escaped};
use crate::files::write_whole;

use keys::{Base, Keys, NEAR};
use read::GltfMaterial;

const EXAMPLE: &str = "Examples:
  cargo xtask material car.glb
  cargo xtask material car.glb --name Paint --json
  cargo xtask material ring.gltf --name Brass --out brass.csv

The output is TOML, one block for each material: put it at the end of a [[surface]] of a plan. metallicFactor from 0.5 on is a
metal. It becomes the named metal whose colour under D65 is within a CIEDE2000 of 5, otherwise a table of n and k with the
colour (Gulbrandsen 2014). KHR_materials_ior, _clearcoat and _iridescence become refractive_index, cover_index and films.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// A glTF 2.0 file, text or binary. Buffers and pictures that it names are not opened.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Only the materials of this name.
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Write the metal's table of n and k to this file, and name it in the keys, even if a named metal is near.
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
    /// Print one JSON object instead of TOML.
    #[arg(long)]
    json: bool,
}

/// A material that a plan can have.
struct Found {
    material: GltfMaterial,
    keys: Keys,
    /// The table of n and k that the keys name, and whether it was written.
    table: Option<(String, bool)>,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let file = args.file.display().to_string();
    let chosen = chosen(read::read(&args.file)?, args.name.as_deref(), &file)?;
    let (mut found, mut refused) = (Vec::new(), Vec::new());
    for material in chosen {
        let subject = format!("{file}: {}", material.label());
        match Keys::new(&material, &subject) {
            Ok(keys) => {
                let table = match keys.base {
                    Base::Dielectric(_) => None,
                    Base::Metal { .. } if keys.named().is_some() => None,
                    Base::Metal { .. } => Some((format!("{}.csv", stem(&material)), false)),
                };
                found.push(Found { material, keys, table });
            }
            Err(error) => refused.push(error),
        }
    }
    if let Some(out) = &args.out {
        write(out, &mut found, &file)?;
    }
    let text = if args.json {
        format!("{:#}\n", object(&file, &found, &refused))
    } else {
        let blocks: Vec<String> = found.iter().map(|found| block(found, &file)).collect();
        blocks.join("\n")
    };
    if !found.is_empty() {
        console.data(&text)?;
    }
    if refused.is_empty() { Ok(Outcome::Done) } else { Err(Errors(refused).into()) }
}

/// All materials, or those of one name.
fn chosen(
    all: Vec<GltfMaterial>,
    name: Option<&str>,
    file: &str,
) -> Result<Vec<GltfMaterial>, Error> {
    let Some(name) = name else { return Ok(all) };
    let known: Vec<String> = all.iter().filter_map(|material| material.name.clone()).collect();
    let chosen: Vec<_> =
        all.into_iter().filter(|material| material.name.as_deref() == Some(name)).collect();
    if !chosen.is_empty() {
        return Ok(chosen);
    }
    // time grows with the length of both
    let first = |text: &str| text.chars().take(64).collect::<String>();
    let distance = |known: &&String| strsim::damerau_levenshtein(&first(name), &first(known));
    let remedy = match known.iter().min_by_key(distance) {
        Some(nearest) => format!("the nearest name is {nearest:?}"),
        None => "its materials have no names: leave --name out".to_owned(),
    };
    Err(Error::new(file, format!("has no material {name:?}")).remedy(remedy))
}

/// Writes the table of the only metal.
fn write(out: &Path, found: &mut [Found], file: &str) -> Result<()> {
    let is_metal = |found: &&mut Found| matches!(found.keys.base, Base::Metal { .. });
    let mut metals: Vec<&mut Found> = found.iter_mut().filter(is_metal).collect();
    let [metal] = metals.as_mut_slice() else {
        let cause =
            format!("{} metals of {file} are asked for, and a table is of one", metals.len());
        return Err(Error::new("--out", cause).remedy("choose a metal with --name").into());
    };
    if let Base::Metal { table, .. } = &metal.keys.base {
        let of = escaped(&metal.material.label());
        write_whole(out, metal::csv(&table.rows, &of).as_bytes())?;
    }
    metal.table = Some((out.display().to_string(), true));
    Ok(())
}

/// A name for a file.
fn stem(material: &GltfMaterial) -> String {
    let name = material.name.as_deref().unwrap_or_default().to_lowercase();
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let stem = words.collect::<Vec<_>>().join("-");
    if stem.is_empty() { format!("material-{}", material.index) } else { stem }
}

/// A block of a plan.
fn block(found: &Found, file: &str) -> String {
    let Found { material, keys, table } = found;
    let label = material.label();
    let mut text = String::new();
    let mut comment = |line: &str| text += &commented(line);
    match &keys.base {
        Base::Dielectric(_) => comment(&format!("{label} of {file}: a dielectric")),
        Base::Metal { table: made, nearest: (name, difference) } => {
            let [r, g, b] = material.base_colour;
            comment(&format!("{label} of {file}: a metal of base colour {r}, {g}, {b}"));
            let nearest =
                format!("the nearest named metal is {name}, at a CIEDE2000 of {difference:.1}");
            comment(&match (keys.named(), table) {
                (Some(_), None) => format!("{nearest}: within {NEAR}, so it is taken"),
                (Some(_), Some(_)) => format!("{nearest}: material = \"{name}\" is recommended"),
                (None, _) => {
                    format!("{nearest}: beyond {NEAR}, so n and k are made from the colour")
                }
            });
            if table.is_some() && made.difference > 0.5 {
                let difference = made.difference;
                comment(&format!("the table's own colour is at a CIEDE2000 of {difference:.1}"));
            }
        }
    }
    text += "[surface.optics]\n";
    text += &match (&keys.base, table) {
        (Base::Dielectric(n), _) => {
            format!("material = \"dielectric\"\nrefractive_index = {n}\n")
        }
        (_, Some((path, _))) => {
            format!("material = {{ nk = {} }}  # relative to the plan's folder\n", json!(path))
        }
        (Base::Metal { nearest: (name, _), .. }, None) => format!("material = \"{name}\"\n"),
    };
    text += &match keys.cover_index {
        1.0 => "cover_index = 1\n".to_owned(),
        n => format!("cover_index = {n}  # KHR_materials_clearcoat, whose index is fixed\n"),
    };
    text += &match keys.film {
        None => "films = []\n".to_owned(),
        Some((n, nm)) => format!(
            "films = [{{ index = {n}, thickness_nm = {nm} }}]  # KHR_materials_iridescence\n"
        ),
    };
    keys.notes.iter().for_each(|note| text += &commented(&format!("note: {note}")));
    if let (Some((path, false)), Base::Metal { table, .. }) = (table, &keys.base) {
        text += &commented(&format!("{path}, which --out FILE.csv writes:"));
        for line in metal::csv(&table.rows, &label).lines().filter(|line| !line.starts_with('#')) {
            text += &format!("#   {line}\n");
        }
    }
    text
}

/// Maximum width of a line, in columns.
const WIDTH: usize = 100;

/// A text as lines of a comment, broken between words.
fn commented(text: &str) -> String {
    let mut lines = vec!["#".to_owned()];
    for word in escaped(text).split_whitespace() {
        let last = lines.len() - 1;
        if lines[last].chars().count() + 1 + word.chars().count() > WIDTH && lines[last].len() > 3 {
            lines.push(format!("#   {word}"));
        } else {
            lines[last] += &format!(" {word}");
        }
    }
    lines.join("\n") + "\n"
}

fn object(file: &str, found: &[Found], refused: &[Error]) -> Value {
    let materials: Vec<Value> = found.iter().map(material_object).collect();
    let refused: Vec<String> = refused.iter().map(ToString::to_string).collect();
    json!({ "file": file, "materials": materials, "refused": refused })
}

fn material_object(Found { material, keys, table }: &Found) -> Value {
    let mut optics = match (&keys.base, table) {
        (Base::Dielectric(n), _) => json!({ "material": "dielectric", "refractive_index": n }),
        (_, Some((path, _))) => json!({ "material": { "nk": path } }),
        (Base::Metal { nearest: (name, _), .. }, None) => json!({ "material": name }),
    };
    let film = |(index, nm): (f64, f64)| json!({ "index": index, "thickness_nm": nm });
    optics["cover_index"] = json!(keys.cover_index);
    optics["films"] = keys.film.map(film).into_iter().collect();
    let mut object = json!({
        "name": material.name,
        "index": material.index,
        "optics": optics,
        "notes": keys.notes,
    });
    if let Base::Metal { table: made, nearest: (name, de2000) } = &keys.base {
        let row = |[nm, n, k]: &[f64; 3]| json!({ "wavelength_nm": nm, "n": n, "k": k });
        object["base_colour"] = json!(material.base_colour);
        object["nearest"] = json!({ "material": name, "de2000": de2000 });
        object["nk"] = made.rows.iter().map(row).collect();
        object["nk_de2000"] = json!(made.difference);
        if let Some((path, true)) = table {
            object["written"] = json!(path);
        }
    }
    object
}
