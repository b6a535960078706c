//! `cargo xtask list`: what a plan means, and what it costs.

use anyhow::Result;
use diffraction_shaders::plan::{Auto, Grating, Plan, SurfaceSource, SurfaceSpec, Variant};
use serde_json::{Value, json};

use crate::Outcome;
use crate::args::PlanArgs;
use crate::console::Console;

const EXAMPLE: &str = "Example:\n  cargo xtask list --plan plan.toml --json";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    plan: PlanArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let plan = args.plan.read(console)?;
    let text = if args.json { format!("{:#}\n", object(&plan)) } else { human(&plan) };
    console.data(&text)?;
    Ok(Outcome::Done)
}

fn object(plan: &Plan) -> Value {
    let rejected =
        |r: &diffraction_shaders::plan::Rejected| json!({ "name": r.name, "reason": r.reason });
    json!({
        "surfaces": plan.surfaces.iter().map(surface_object).collect::<Vec<_>>(),
        "variants": plan.variants.iter().map(variant_object).collect::<Vec<_>>(),
        "targets": plan.targets.iter().map(|target| target.as_str()).collect::<Vec<_>>(),
        "rejected": plan.rejected.iter().map(rejected).collect::<Vec<_>>(),
        "notes": plan.notes,
    })
}

fn surface_object(surface: &SurfaceSpec) -> Value {
    match &surface.source {
        SurfaceSource::Grating(grating) => json!({ "name": surface.name, "grating": grating }),
        SurfaceSource::File(file) => {
            json!({ "name": surface.name, "file": file.path.display().to_string() })
        }
    }
}

fn variant_object(variant: &Variant) -> Value {
    let waves = &variant.wavelengths;
    let cost = variant.cost().map(|cost| {
        json!({
            "evaluations_mean": cost.evaluations,
            "evaluations_worst": cost.evaluations,
            "term_fetches": cost.term_fetches,
            "spectrum_fetches": cost.spectrum_fetches,
            "fetches": cost.fetches(),
        })
    });
    json!({
        "name": variant.name,
        "mode": variant.mode,
        "basis": variant.basis,
        "terms": auto(variant.terms),
        "window_radius": auto(variant.window_radius),
        "wavelengths": waves,
        "samples": waves.count(),
        "table": variant.table,
        "packing": variant.packing,
        "hoist": variant.hoist,
        "optics": variant.optics,
        "hash": variant.hash(),
        "cost": cost,
    })
}

fn auto(value: Auto<u32>) -> Value {
    match value {
        Auto::Value(n) => json!(n),
        Auto::Auto => json!("auto"),
    }
}

fn human(plan: &Plan) -> String {
    let surfaces = plan.surfaces.iter().map(|surface| vec![surface.name.clone(), source(surface)]);
    let variants = plan.variants.iter().map(|variant| {
        let or_auto = |value: Auto<u32>| auto(value).to_string().replace('"', "");
        let cost = |of: fn(&diffraction_shaders::plan::Cost) -> u64| {
            variant.cost().map_or_else(|| "auto".to_owned(), |cost| of(&cost).to_string())
        };
        vec![
            variant.name.clone(),
            variant.mode.as_str().to_owned(),
            variant.basis.as_str().to_owned(),
            or_auto(variant.terms),
            or_auto(variant.window_radius),
            cost(|cost| cost.evaluations),
            cost(|cost| cost.term_fetches),
            cost(|cost| cost.fetches()),
        ]
    });
    let mut text = table(&["surface", "heights"], surfaces.collect());
    text.push('\n');
    let head =
        ["variant", "mode", "basis", "terms", "radius", "evaluations", "term fetches", "fetches"];
    text += &table(&head, variants.collect());
    text += "per pixel; every lit pixel costs the same\n\n";
    let targets: Vec<&str> = plan.targets.iter().map(|target| target.as_str()).collect();
    text += &format!("targets: {}\n", targets.join(", "));
    if !plan.rejected.is_empty() {
        let rejected = plan.rejected.iter().map(|r| vec![r.name.clone(), r.reason.clone()]);
        text.push('\n');
        text += &table(&["rejected", "reason"], rejected.collect());
    }
    text
}

fn source(surface: &SurfaceSpec) -> String {
    match &surface.source {
        SurfaceSource::File(file) => file.path.display().to_string(),
        SurfaceSource::Grating(grating) => match grating {
            Grating::Flat { .. } => "flat".to_owned(),
            Grating::Sinusoidal { period_um, .. } => format!("sinusoidal, {period_um} µm"),
            Grating::Blazed { period_um, .. } => format!("blazed, {period_um} µm"),
            Grating::Lamellar { period_um, .. } => format!("lamellar, {period_um} µm"),
            Grating::Triangle { period_um, .. } => format!("triangle, {period_um} µm"),
            Grating::Crossed { .. } => "crossed".to_owned(),
            Grating::Bumps(rough) => format!("bumps, {} µm", rough.size_um),
            Grating::Fingers(rough) => format!("fingers, {} µm", rough.size_um),
            Grating::Rows(rough) => format!("rows, {} µm", rough.size_um),
        },
    }
}

/// Columns as wide as their widest cell; numbers to the right.
fn table(head: &[&str], rows: Vec<Vec<String>>) -> String {
    let head = head.iter().map(ToString::to_string).collect();
    let rows: Vec<Vec<String>> = std::iter::once(head).chain(rows).collect();
    let columns = rows[0].len();
    let width =
        |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let is_number = |column: usize| {
        rows.len() > 1
            && rows[1..]
                .iter()
                .all(|row| row[column] == "auto" || row[column].parse::<f64>().is_ok())
    };
    let mut text = String::new();
    for row in &rows {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, width))| {
            if is_number(column) { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
        });
        text += cells.collect::<Vec<_>>().join("  ").trim_end();
        text.push('\n');
    }
    text
}
