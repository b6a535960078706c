//! `cargo xtask list`: what a plan builds, and what each variant costs.

pub mod table;

use std::collections::BTreeMap;

use anyhow::Result;
use diffraction_shaders::error::Error;
use diffraction_shaders::input::SurfaceInput;
use diffraction_shaders::plan::{
    Grating, Mode, Plan, Rejected, SurfaceSource, SurfaceSpec, Variant, vocabulary,
};
use diffraction_shaders::survey::memory::{self, Memory};
use diffraction_shaders::tables::Series;
use diffraction_shaders::variant::Form;
use serde_json::{Map, Value, json};

use crate::Outcome;
use crate::args::PlanArgs;
use crate::console::{Console, Errors};
use crate::memory::MemoryArgs;

const EXAMPLE: &str = "Examples:
  cargo xtask list
  cargo xtask list --plan plan.toml --json";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    plan: PlanArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let plan = args.plan.read(console)?;
    let costs = costs(&plan, console);
    let text =
        if args.json { format!("{:#}\n", object(&plan, &costs)) } else { human(&plan, &costs) };
    console.data(&text)?;
    let budget = args.memory.budget();
    let refused = costs.iter().filter_map(|((variant, surface), on)| {
        let subject = format!("surface {surface}: variant {variant}");
        memory::within_budget(&subject, on.peak_bytes, budget).err()
    });
    let refused: Vec<Error> = refused.collect();
    if refused.is_empty() { Ok(Outcome::Done) } else { Err(Errors(refused).into()) }
}

/// A variant as built on a surface.
struct On {
    variant: Variant,
    form: Form,
    /// Estimated memory of `generate` while it builds this variant, in bytes.
    peak_bytes: u64,
}

/// Each variant as built on each readable surface, by the names of variant and surface.
type Costs = BTreeMap<(String, String), On>;

fn costs(plan: &Plan, console: &Console) -> Costs {
    let mut costs = Costs::new();
    let threads = rayon::current_num_threads();
    let mut held = 0;
    for spec in &plan.surfaces {
        // the plan can be listed without the heights
        let unknown = |error: &Error| console.note(&format!("costs are unknown: {error}"));
        let read = match SurfaceInput::read(spec) {
            Ok(read) => read,
            Err(error) => {
                unknown(&error);
                continue;
            }
        };
        match read.surface() {
            Ok(surface) => {
                held += read.held_bytes();
                for variant in plan.variants.iter().filter_map(|variant| variant.on(spec)) {
                    let form = |v: Variant| Form::new(&v, &surface.field).map(|form| (v, form));
                    match variant.and_then(form) {
                        Ok((variant, form)) => {
                            let key = (variant.name.clone(), spec.name.clone());
                            let memory = Memory::new(&surface.field, &variant, &form, threads);
                            let peak_bytes = memory.to_build(plan.containers.len());
                            costs.insert(key, On { variant, form, peak_bytes });
                        }
                        Err(reason) => console.note(&format!("{}: left out: {reason}", spec.name)),
                    }
                }
            }
            Err(error) => unknown(&error),
        }
    }
    let around = memory::around_bytes(held, costs.len());
    costs.values_mut().for_each(|on| on.peak_bytes += around);
    costs
}

fn object(plan: &Plan, costs: &Costs) -> Value {
    let rejected = |r: &Rejected| json!({ "name": r.name, "reason": r.reason });
    json!({
        "surfaces": plan.surfaces.iter().map(surface_object).collect::<Vec<_>>(),
        "variants": plan.variants.iter().map(|variant| variant_object(variant, plan, costs)).collect::<Vec<_>>(),
        "targets": plan.targets.iter().map(|target| target.as_str()).collect::<Vec<_>>(),
        "rejected": plan.rejected.iter().map(rejected).collect::<Vec<_>>(),
        "notes": plan.notes,
    })
}

/// Name and source of a surface.
pub(crate) fn surface_object(surface: &SurfaceSpec) -> Value {
    let mut object = match &surface.source {
        SurfaceSource::Grating(grating) => json!({ "name": surface.name, "grating": grating }),
        SurfaceSource::File(file) => {
            json!({ "name": surface.name, "file": file.path.display().to_string() })
        }
    };
    if !surface.optics.is_empty() {
        object["optics"] = json!(surface.optics);
    }
    object
}

fn variant_object(variant: &Variant, plan: &Plan, costs: &Costs) -> Value {
    let cost = plan.surfaces.iter().filter_map(|surface| {
        let On { variant: here, form: on, peak_bytes } =
            costs.get(&(variant.name.clone(), surface.name.clone()))?;
        let counted = on.cost();
        let mut cost = json!({
            "surface": surface.name,
            "terms": on.series().map(Series::terms),
            "window_radius": on.window_radius(),
            "evaluations_mean": counted.evaluations_mean,
            "evaluations_worst": counted.evaluations,
            "term_fetches": counted.term_fetches,
            "fetches": counted.fetches,
            "fetches_mean": counted.fetches_mean,
            "table_bytes": counted.table_bytes,
            "peak_memory_bytes": peak_bytes,
        });
        if on.series().is_some_and(Series::is_accepted) {
            cost["error_accepted"] = json!(true);
        }
        // the surface has optics of its own
        if here.hash() != variant.hash() {
            cost["configuration"] = json!(configuration(here));
            cost["hash"] = json!(here.hash());
        }
        Some(cost)
    });
    let mut object: Map<String, Value> =
        variant.settings().map(|(key, value)| (key.to_owned(), value)).collect();
    // the optics have an object of their own
    if let Value::Object(optics) = json!(variant.optics) {
        object.retain(|key, _| !optics.contains_key(key));
    }
    let more = json!({
        "name": variant.name,
        "samples": samples(variant),
        "optics": variant.optics,
        "configuration": configuration(variant),
        "hash": variant.hash(),
        "cost": cost.collect::<Vec<_>>(),
    });
    object.extend(more.as_object().cloned().into_iter().flatten());
    if let Some(surfaces) = &variant.surfaces {
        object.insert("surfaces".to_owned(), json!(surfaces));
    }
    Value::Object(object)
}

/// The keys that a variant reads, with their values. Its hash is computed from them.
fn configuration(variant: &Variant) -> Map<String, Value> {
    serde_json::from_str(&variant.canonical()).unwrap_or_default()
}

/// Number of wavelength samples, in modes with uniform wavelengths.
fn samples(variant: &Variant) -> Value {
    if variant.has_uniform_wavelengths() {
        json!(variant.wavelengths.nodes_nm().len())
    } else {
        Value::Null
    }
}

fn human(plan: &Plan, costs: &Costs) -> String {
    let surfaces = plan.surfaces.iter().map(|surface| {
        let optics = shown(configured(&json!(surface.optics)));
        let source = [source(surface)].into_iter().chain(optics).collect::<Vec<_>>();
        vec![surface.name.clone(), source.join(", ")]
    });
    let mut text = table::text(&["surface", "heights"], surfaces.collect());
    text.push('\n');
    text += &configurations(&plan.variants);
    text.push('\n');
    text += &cost_table(plan, costs);
    let targets: Vec<&str> = plan.targets.iter().map(|target| target.as_str()).collect();
    text += &format!("targets: {}\n", targets.join(", "));
    if !plan.rejected.is_empty() {
        text += "\nrejected\n";
        for Rejected { name, reason } in &plan.rejected {
            let words: Vec<String> = reason.split(' ').map(str::to_owned).collect();
            text += &table::wrapped(&format!("  {name}:"), &words, " ");
        }
    }
    text
}

/// A number, or a dash in place of `None`.
pub(crate) fn or_dash(number: Option<u32>) -> String {
    number.map_or_else(|| "-".to_owned(), |number| number.to_string())
}

/// The settings of the variants, mode by mode: first those that all variants of a mode share, then those of each variant.
fn configurations(variants: &[Variant]) -> String {
    let mut modes: Vec<Mode> = Vec::new();
    for variant in variants {
        if !modes.contains(&variant.mode) {
            modes.push(variant.mode);
        }
    }
    let mut text = String::new();
    for mode in modes {
        let of_mode = || variants.iter().filter(move |variant| variant.mode == mode);
        let all: Vec<Vec<String>> = of_mode().map(settings).collect();
        let is_shared = |setting: &String| all.iter().all(|of_one| of_one.contains(setting));
        let shared: Vec<String> = all[0].iter().filter(|s| is_shared(s)).cloned().collect();
        text += &table::wrapped(&format!("mode {}:", mode.as_str()), &shared, ", ");
        for (variant, settings) in of_mode().zip(&all) {
            let own: Vec<String> = settings.iter().filter(|s| !is_shared(s)).cloned().collect();
            text += &table::wrapped(&format!("  {}:", variant.name), &own, ", ");
        }
    }
    text
}

/// The settings of a variant without the mode, and the surfaces that it is for.
fn settings(variant: &Variant) -> Vec<String> {
    let mut settings = configured(&json!(configuration(variant)));
    settings.retain(|(name, _)| name != "mode");
    let surfaces = variant.surfaces.iter().map(|names| format!("on {} only", names.join(" and ")));
    shown(settings).into_iter().chain(surfaces).collect()
}

/// The entries of an object in the order of the plan's keys.
fn configured(object: &Value) -> Vec<(String, Value)> {
    let is_axis = |table: &str| matches!(table, "variants" | "variants.wavelengths");
    let order: Vec<String> =
        vocabulary().into_iter().filter(|key| is_axis(key.table)).map(|key| key.name).collect();
    let place = |name: &String| order.iter().position(|known| known == name).unwrap_or(order.len());
    let mut settings: Vec<(String, Value)> =
        object.as_object().cloned().into_iter().flatten().collect();
    settings.sort_by_key(|(name, _)| place(name));
    settings
}

fn shown(settings: Vec<(String, Value)>) -> Vec<String> {
    let shown = |value: Value| match value {
        Value::String(word) => word,
        Value::Number(n) => n.as_f64().map_or_else(|| n.to_string(), |x| x.to_string()),
        other => other.to_string(),
    };
    settings.into_iter().map(|(name, value)| format!("{name} {}", shown(value))).collect()
}

/// The costs of every variant. Surfaces with the same costs share a line.
fn cost_table(plan: &Plan, costs: &Costs) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut starts: Vec<(usize, String)> = Vec::new();
    for variant in &plan.variants {
        let begin = rows.len();
        for surface in &plan.surfaces {
            let Some(On { form: on, peak_bytes, .. }) =
                costs.get(&(variant.name.clone(), surface.name.clone()))
            else {
                continue;
            };
            let cost = on.cost();
            let numbers = [
                or_dash(on.series().map(Series::terms)),
                or_dash(on.window_radius()),
                format!("{:.1}", cost.evaluations_mean),
                cost.evaluations.to_string(),
                cost.term_fetches.to_string(),
                format!("{:.1}", cost.fetches_mean),
                cost.fetches.to_string(),
                format!("{:.1}", cost.table_bytes as f64 / 1024.0),
                format!("{:.2}", *peak_bytes as f64 / f64::from(1 << 30)),
            ];
            match rows[begin..].iter_mut().find(|row| row[..9] == numbers) {
                Some(row) => row[9] = format!("{}, {}", row[9], surface.name),
                None => rows.push(numbers.into_iter().chain([surface.name.clone()]).collect()),
            }
        }
        for row in &mut rows[begin..] {
            row[9] = shortened(&row[9]);
        }
        if rows.len() > begin {
            let is_accepted = costs.iter().any(|((name, _), on)| {
                *name == variant.name && on.form.series().is_some_and(Series::is_accepted)
            });
            let mark =
                if is_accepted { " (error above its limit, accepted by the plan)" } else { "" };
            starts.push((begin, format!("{}{mark}", variant.name)));
        }
    }
    if rows.is_empty() {
        return String::new();
    }
    let head = [
        "terms",
        "radius",
        "evaluations",
        "worst",
        "term fetches",
        "fetches",
        "worst",
        "KiB",
        "GiB",
        "on",
    ];
    let lines = table::text(&head, rows);
    let mut text = String::new();
    for (i, line) in lines.lines().enumerate() {
        // line 0 is the heading
        for (_, name) in starts.iter().filter(|(start, _)| i > 0 && *start == i - 1) {
            text += &format!("{name}\n");
        }
        text += &format!("  {line}\n");
    }
    text + "evaluations, fetches: per lit pixel, mean and worst case; term fetches: worst case; KiB: all tables;\n\
           GiB: peak of memory while generate builds the variant, estimated;\n\
           modes with uniform wavelengths cost the same in every lit pixel\n\n"
}

/// A list of names; of many names the first ones, and how many more there are.
fn shortened(names: &str) -> String {
    const SHOWN: usize = 12;
    let all: Vec<&str> = names.split(", ").collect();
    match all.len() - SHOWN.min(all.len()) {
        0 => names.to_owned(),
        more => format!("{} and {more} more", all[..SHOWN].join(", ")),
    }
}

/// The source of a surface in a few words.
pub(crate) fn source(surface: &SurfaceSpec) -> String {
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
