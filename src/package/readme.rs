//! `README.md` of a package: its variants, sizes and costs, and the reason of every gap.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use serde_json::Value;

use crate::error::{Error, Result};
use crate::package::Package;
use crate::plan::{Rejected, Target};
use crate::shader::template::GENERATED;

/// Name of the file.
pub const FILE: &str = "README.md";

/// Writes the text from the package's manifests (including those kept from an earlier run), from the keys of its index
/// and from the combinations that the plan's constraints reject. Sizes are those of the written files.
pub fn readme(
    package: &Package,
    index: &BTreeMap<String, Value>,
    rejected: &[Rejected],
) -> Result<String> {
    let mut surfaces: BTreeMap<String, Vec<VariantLine>> = BTreeMap::new();
    for (path, file) in package.files() {
        if path.starts_with("shaders/") && path.ends_with("/manifest.json") {
            let manifest: Value = serde_json::from_slice(&file.content.read()?).map_err(|e| {
                Error::new(path, "is not valid JSON")
                    .source(e)
                    .remedy("generate the whole package again")
            })?;
            let row = VariantLine::new(package, path, &manifest)?;
            surfaces.entry(text(&manifest["surface"])).or_default().push(row);
        }
    }
    let targets: Vec<Target> = index.get("targets").map_or(Vec::new(), |targets| {
        let words = targets.as_array().into_iter().flatten().filter_map(Value::as_str);
        words.filter_map(|word| Target::parse(word).ok()).collect()
    });
    let mut out = format!("<!-- {GENERATED} -->\n\n# Generated diffraction shaders\n\n{ABOUT}");
    for (surface, rows) in &surfaces {
        section(&mut out, surface, rows, &targets);
    }
    gaps(&mut out, &surfaces, index, rejected, &targets);
    Ok(out)
}

const ABOUT: &str = "\
`manifest.json` lists every file. `shaders/SURFACE/VARIANT/` holds the shaders of one variant, its `manifest.json` (bindings,
uniforms, requirements, error bound), `bindings.rs` and `probe.json` (64 directions with their colours, to test an
integration with); `surfaces/SURFACE/` holds the tables that its variants share.

The columns of languages give the size of all files of a language in KiB, function form included. The column `tables` gives the
size of all tables that a variant binds, in KiB. `evaluations` is the number of evaluations of the amplitude for one lit pixel,
`fetches` the number of texels read. Where these depend on the direction, the table gives mean / maximum.
";

/// A variant on a surface.
struct VariantLine {
    variant: String,
    sizes: BTreeMap<String, u64>,
    table_bytes: u64,
    evaluations: String,
    fetches: String,
    profiles: Vec<String>,
    misfits: Vec<(String, String)>,
    is_accepted: bool,
}

impl VariantLine {
    fn new(package: &Package, path: &str, manifest: &Value) -> Result<VariantLine> {
        let folder = path.trim_end_matches("manifest.json");
        let mut sizes = BTreeMap::new();
        for (target, files) in manifest["targets"].as_object().into_iter().flatten() {
            let names = files.as_array().into_iter().flatten().map(|file| text(&file["file"]));
            let mut size = 0;
            for name in names {
                if let Some(file) = package.files().get(&format!("{folder}{name}")) {
                    size += file.content.byte_count()?;
                }
            }
            sizes.insert(target.clone(), size);
        }
        let mut table_bytes = 0;
        for table in manifest["tables"].as_array().into_iter().flatten() {
            let data = text(&table["data"]).replace("../../../", "");
            if let Some(file) = package.files().get(&data) {
                table_bytes += file.content.byte_count()?;
            }
        }
        let cost = |worst: &str, mean: &str| {
            let (worst, mean) = (&manifest["cost"][worst], manifest["cost"][mean].as_f64());
            match (worst.as_f64(), mean) {
                (Some(w), Some(m)) if (w - m).abs() > 0.05 => format!("{m:.1} / {worst}"),
                _ => worst.to_string(),
            }
        };
        let requires = &manifest["requires"];
        let profiles = requires["profiles"].as_array().into_iter().flatten().map(text);
        let misfits = requires["gaps"].as_object().into_iter().flatten();
        Ok(VariantLine {
            variant: text(&manifest["variant"]),
            sizes,
            table_bytes,
            evaluations: cost("evaluations", "evaluations_mean"),
            fetches: cost("fetches", "fetches_mean"),
            profiles: profiles.collect(),
            misfits: misfits.map(|(name, reason)| (name.clone(), text(reason))).collect(),
            is_accepted: manifest["error_bound"]["accepted"] == true,
        })
    }
}

fn section(out: &mut String, surface: &str, rows: &[VariantLine], targets: &[Target]) {
    let names: Vec<&str> = targets.iter().map(|target| target.as_str()).collect();
    let _ = write!(out, "\n## {surface}\n\n| variant |");
    names.iter().for_each(|name| *out += &format!(" {name} |"));
    *out += " tables | evaluations | fetches | fits |\n| --- |";
    *out += &" --: |".repeat(names.len() + 3);
    *out += " --- |\n";
    for row in rows {
        let _ = write!(out, "| {} |", row.variant);
        for name in &names {
            let size = row.sizes.get(*name).map_or_else(|| "—".to_owned(), |size| kib(*size));
            let _ = write!(out, " {size} |");
        }
        let VariantLine { table_bytes, evaluations, fetches, profiles, .. } = row;
        let (tables, profiles) = (kib(*table_bytes), profiles.join(", "));
        let _ = writeln!(out, " {tables} | {evaluations} | {fetches} | {profiles} |");
    }
}

fn gaps(
    out: &mut String,
    surfaces: &BTreeMap<String, Vec<VariantLine>>,
    index: &BTreeMap<String, Value>,
    rejected: &[Rejected],
    targets: &[Target],
) {
    let mut lines = Vec::new();
    for Rejected { name, reason } in rejected {
        lines.push(format!("`{name}` is not built: {reason}"));
    }
    for gap in index.get("gaps").and_then(Value::as_array).into_iter().flatten() {
        let [surface, variant, reason] =
            ["surface", "variant", "reason"].map(|key| text(&gap[key]));
        lines.push(format!("`{variant}` is not built on `{surface}`: {reason}"));
    }
    for (surface, rows) in surfaces {
        for row in rows {
            if row.is_accepted {
                let variant = &row.variant;
                lines.push(format!(
                    "`{variant}` on `{surface}` may show wrong colours: its error is above the limit, and the plan accepts that"
                ));
            }
            for (profile, reason) in &row.misfits {
                let variant = &row.variant;
                lines.push(format!("`{variant}` on `{surface}` does not fit {profile}: {reason}"));
            }
        }
    }
    if targets.contains(&Target::Msl) {
        lines.push(
            "`msl` is compiled and run on the CPU by `cargo xtask validate`, but not by Apple's compiler, which runs on Apple's machines only."
                .to_owned(),
        );
    }
    if targets.contains(&Target::Hlsl) {
        let line = "`hlsl` is compiled by DXC and glslangValidator where they are installed (`cargo xtask validate`), but was not drawn by Direct3D.";
        lines.push(line.to_owned());
    }
    let absent: BTreeSet<&str> =
        Target::all().into_iter().filter(|t| !targets.contains(t)).map(Target::as_str).collect();
    for target in absent {
        lines.push(format!("`{target}` is not among the plan's targets."));
    }
    *out += "\n## What is missing, and why\n\n";
    if lines.is_empty() {
        *out += "Nothing.\n";
    }
    lines.iter().for_each(|line| *out += &format!("- {}\n", line.replace('\n', " ")));
}

/// KiB with one decimal.
fn kib(bytes: u64) -> String {
    format!("{:.1}", bytes as f64 / 1024.0)
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}
