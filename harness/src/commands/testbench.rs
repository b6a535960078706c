//! `cargo xtask testbench`: measures the period of a surface as variants show it.

mod args;
mod task;
mod text;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use diffraction_cli::Outcome;
use diffraction_cli::console::Console;
use diffraction_cli::files::write_whole;
use diffraction_cli::progress;
use diffraction_shaders::input;
use diffraction_shaders::plan::{Plan, SurfaceSpec};
use diffraction_shaders::surface::{self, Surface};

use crate::commands::restart;
use crate::period::{Crop, HeatmapText, Protocol, csv, expected_um, heatmap, layout, spread};
use crate::results::{self, Gap, Log, Record, Testbench};

pub(crate) use args::Args;
use task::{Found, Task, gap};

/// Folder of the pictures, under `--out`.
const PICTURES: &str = "pictures/testbench";

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    if args.runner().is_driver() {
        restart::with_drivers()?;
    }
    let plan: Plan = args.surface.plan.read(console)?;
    let spec = plan.surface(&args.surface.surface)?;
    let plan = plan.on(spec);
    let (tasks, mut gaps) = task::tasks(args, &plan)?;
    if let ([], [gap]) = (tasks.as_slice(), gaps.as_slice()) {
        bail!("variant {}: {}", gap.variant.as_deref().unwrap_or_default(), gap.reason);
    }
    let surface = input::load_surface(spec)?;
    surface.notes.iter().for_each(|note| console.note(note));
    let protocol = protocol(args, spec, &surface)?;
    let crops = crops(args, spec, &surface)?;
    let mut log = log(args, console)?;
    let bar = progress::bar(tasks.len() * crops.len(), "measuring");
    let mut results = Vec::new();
    for task in &tasks {
        let mut found = Vec::new();
        for (number, crop) in crops.iter().enumerate() {
            let field = Task::field(&surface, *crop)?;
            bar.inc(1);
            if let Some(reason) = task.refusal(&field) {
                if args.variant.is_some() {
                    bail!("variant {}: {reason}", task.name);
                }
                // all windows would be refused for the same reason
                gaps.push(gap(&spec.name, &task.name, args.runner_name(), reason));
                break;
            }
            let held = surface.field.byte_count() + field.byte_count();
            args.memory.check(&spec.name, &task.name, held, task.memory(&field)?)?;
            let one = task.measure(spec, field, crop.is_none(), &protocol)?;
            if one.measurement.points == 0 {
                gaps.push(gap(&spec.name, &task.name, one.route.clone(), nothing(&one)));
                continue;
            }
            let several = tasks.len() * crops.len() > 1;
            let suffix = several.then(|| match crop {
                Some(_) => format!("-{}-w{}", task.name, number + 1),
                None => format!("-{}", task.name),
            });
            let svg = write(args, spec, &one, suffix.as_deref().unwrap_or_default())?;
            let result = one.record(&spec.name, *crop, svg);
            keep(&mut log, &Record::Testbench(result.clone()))?;
            results.push(result);
            found.push(one);
        }
        if args.windows(&surface.field).is_some()
            && let Some(result) = together(spec, &found)
        {
            keep(&mut log, &Record::Testbench(result.clone()))?;
            results.push(result);
        }
    }
    for gap in &gaps {
        keep(&mut log, &Record::Gap(gap.clone()))?;
    }
    bar.finish_and_clear();
    let text = match args.json {
        true => lines(&results, &gaps)?,
        false => text::table(&spec.name, &protocol, &results, &gaps),
    };
    console.data(&text)?;
    if results.is_empty() {
        bail!(
            "{}: no period was found (give the expected period with --period-nm)",
            surface::subject(spec)
        );
    }
    Ok(Outcome::Done)
}

/// Opens the file of records under `--out`.
fn log(args: &Args, console: &Console) -> Result<Option<Log>> {
    let Some(folder) = &args.out else { return Ok(None) };
    let log = Log::open(folder, &|text| console.note(text))?;
    let pictures = folder.join(PICTURES);
    fs::create_dir_all(&pictures).with_context(|| pictures.display().to_string())?;
    Ok(Some(log))
}

/// Appends a result at once, so that an interrupt loses no results.
fn keep(log: &mut Option<Log>, record: &Record) -> Result<()> {
    Ok(log.as_mut().map_or(Ok(()), |log| log.append(record))?)
}

fn protocol(args: &Args, spec: &SurfaceSpec, surface: &Surface) -> Result<Protocol> {
    let (field, subject) = (&surface.field, surface::subject(spec));
    field.check_pitch(&subject, args.wavelengths.0.min_nm)?;
    let along_deg = args.phi_i - spec.rotate_deg;
    let expected_um = match args.period_nm {
        Some(nm) => nm * 1e-3,
        None => expected_um(field, task::tiled(spec, field)?, along_deg, &subject)?,
    };
    Ok(Protocol {
        theta_i_deg: args.theta_i,
        phi_i_deg: args.phi_i,
        wavelengths: args.wavelengths.0,
        expected_um,
        // pictures and tables show all angles
        whole: args.csv.is_some() || args.svg.is_some() || args.out.is_some(),
    })
}

fn crops(args: &Args, spec: &SurfaceSpec, surface: &Surface) -> Result<Vec<Option<Crop>>> {
    let Some((count, side_um)) = args.windows(&surface.field) else { return Ok(vec![None]) };
    let found = layout(&surface.field, count, side_um, &surface::subject(spec))?;
    Ok(found.into_iter().map(Some).collect())
}

/// Writes the requested files. Returns the picture's name.
fn write(args: &Args, spec: &SurfaceSpec, one: &Found, suffix: &str) -> Result<Option<String>> {
    if let Some(path) = &args.csv {
        write_whole(&suffixed(path, suffix), csv(&one.measurement).as_bytes())?;
    }
    let (path, named) = match (&args.svg, &args.out) {
        (Some(path), _) => (suffixed(path, suffix), None),
        (None, Some(folder)) => {
            let place = format!("{PICTURES}/{}{suffix}.svg", spec.name);
            (folder.join(&place), Some(place))
        }
        (None, None) => return Ok(None),
    };
    let title = format!(
        "{}, {}, θi {}°: period {:.3} nm, standard deviation {:.3} nm",
        spec.name,
        one.variant,
        one.protocol.theta_i_deg,
        one.measurement.period_nm,
        one.measurement.sd_nm
    );
    let picture = HeatmapText { title: &title, yardstick: one.yardstick.as_ref() };
    write_whole(&path, heatmap(&one.measurement, &one.protocol, picture)?.as_bytes())?;
    Ok(named.or_else(|| path.file_name().map(|name| name.to_string_lossy().into_owned())))
}

/// The path with a suffix before its extension.
fn suffixed(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(suffix);
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// The summary of all windows of one variant.
fn together(spec: &SurfaceSpec, found: &[Found]) -> Option<Testbench> {
    let all = spread(found.iter().map(|one| &one.measurement))?;
    let sum = |of: fn(&Found) -> usize| found.iter().map(of).sum();
    Some(Testbench {
        period_nm: all.period_nm,
        sd_nm: all.sd_nm,
        points: sum(|one| one.measurement.points),
        evanescent: sum(|one| one.measurement.evanescent),
        flat: sum(|one| one.measurement.flat),
        windows: Some((all.windows, all.spread_nm)),
        weight: all.weight,
        ..found.first()?.record(&spec.name, None, None)
    })
}

fn nothing(one: &Found) -> String {
    let Protocol { wavelengths, expected_um, .. } = one.protocol;
    let period_nm = 1e3 * expected_um;
    if one.measurement.flat == 0 {
        let min_nm = wavelengths.min_nm;
        return format!("the first order of {period_nm:.1} nm is evanescent from {min_nm} nm up");
    }
    format!("the response has no maximum near the first order of {period_nm:.1} nm")
}

fn lines(results: &[Testbench], gaps: &[Gap]) -> Result<String> {
    let results = results.iter().cloned().map(Record::Testbench);
    results.chain(gaps.iter().cloned().map(Record::Gap)).map(|r| Ok(results::line(&r)?)).collect()
}
