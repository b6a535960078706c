//! From a plan to the winner: candidates, errors, times, records.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use diffraction_cli::console::Console;
use diffraction_cli::files::write_whole;
use diffraction_cli::{Outcome, interrupt, progress};
use diffraction_shaders::field::reference::{Reference, Span};
use diffraction_shaders::input;
use diffraction_shaders::optics::Matter;
use diffraction_shaders::plan::{Plan, SurfaceSpec, Variant};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::shader::limits::Profile;
use diffraction_shaders::surface::{self, HeightField};
use diffraction_shaders::survey::memory::{self, Memory};
use diffraction_shaders::variant::Form;
use indicatif::ProgressBar;

use super::timing::{self, Timee};
use super::{Args, Fits, text};
use crate::bench::driver::Scene;
use crate::drivers::gpu::Gpu;
use crate::report::front_picture;
use crate::results::{self, Log, Record, Tune, Verdict};
use crate::tune::candidates::candidates;
use crate::tune::colours::Truth;
use crate::tune::prune::{Limits, lose, prune};
use crate::tune::search::{search, to_time};
use crate::tune::verdict::{Baseline, Results, Run, settle};
use crate::tune::{Candidate, Lost};

/// The lights if `--light` is not given: several, so that a winner is not tuned to one light.
const LIGHTS: [[f64; 2]; 4] = [[20.0, 0.0], [0.0, 0.0], [60.0, 0.0], [75.0, 0.0]];

/// How often a bar shows that work without steps goes on.
const TICK: Duration = Duration::from_millis(200);
/// Steps of a progress bar for work without steps of its own.
const STEPS: usize = 1000;

pub(super) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let plan = args.surface.plan.read(console)?;
    let spec = plan.surface(&args.surface.surface)?.clone();
    let plan = plan.on(&spec);
    let gpu = timing::open(args)?;
    let surface = input::load_surface(&spec)?;
    surface.notes.iter().for_each(|note| console.note(note));
    surface.field.check_pitch(&surface::subject(&spec), 380.0)?;
    if let Some(folder) = &args.out {
        let made = std::fs::create_dir_all(folder.join("pictures"));
        made.with_context(|| format!("--out {}: cannot be created", folder.display()))?;
    }
    let lights: Vec<[f64; 2]> = match args.light.as_slice() {
        [] => LIGHTS.to_vec(),
        given => given.iter().map(|light| [light.theta_deg, light.phi_deg]).collect(),
    };
    let limits = Limits {
        budget_de: args.budget_de,
        fits: args.fits.map(|fits| match fits {
            Fits::Webgl2 => Profile::Webgl2,
            Fits::Webgpu => Profile::Webgpu,
        }),
        max_table_mib: args.max_table_mib,
    };
    let info = gpu.info().clone();
    let run = Run {
        surface: &spec.name,
        plan: &plan,
        limits,
        lights: &lights,
        adapter: [info.backend.name(), &info.name],
        size: args.size as usize,
    };
    let results = results(&run, args, &gpu, &plan, &spec, &surface.field, console)?;
    let records = settle(&run, &results);
    if let Some(folder) = &args.out {
        keep(folder, &records, console)?;
    }
    let shown = match args.json {
        true => {
            let lines = records.iter().map(|r| results::line(&Record::Tune(r.clone())));
            lines.collect::<Result<String, _>>()?
        }
        false => text::text(&records, args.all),
    };
    console.data(&shown)?;
    let has_winner = records.iter().any(|r| r.verdict == Verdict::Winner);
    let is_within = records.iter().any(|r| r.verdict == Verdict::Within);
    if is_within && !has_winner {
        bail!("{}: candidates are within the budget, but none could be timed", info);
    }
    if !has_winner {
        console.note(&text::help(&records));
    }
    Ok(if has_winner { Outcome::Done } else { Outcome::Findings })
}

fn results(
    run: &Run<'_>,
    args: &Args,
    gpu: &Gpu,
    plan: &Plan,
    spec: &SurfaceSpec,
    height: &HeightField,
    console: &Console,
) -> Result<Results> {
    let rotate_deg = spec.rotate_deg;
    let stop = interrupt::flag()?;
    let stopped = || stop.load(Ordering::Relaxed);
    let bar = stage(console, "which candidates can be built");
    let (all, mut lost) = candidates(plan, height);
    let (candidates, pruned) = prune(all, &run.limits, rotate_deg);
    lost.extend(pruned);
    let (candidates, too_large) = affordable(candidates, height, args.memory.budget());
    lost.extend(too_large);
    bar.finish_and_clear();
    let matter = Matter::new(&plan.optics)?;
    let exact = Reference::working_bytes(height, &plan.optics, &matter, Span::ANYWHERE);
    args.memory.check(&spec.name, "exact", height.byte_count(), exact)?;

    console.note(&format!(
        "{} candidates; now the exact colours under {} lights",
        candidates.len(),
        run.lights.len()
    ));
    let bar = progress::bar(Truth::directions() * run.lights.len(), "exact colours");
    // transforms come first, without steps of their own
    bar.enable_steady_tick(TICK);
    let done = |count: usize| {
        bar.inc(count as u64);
        if stopped() {
            interrupt::exit();
        }
    };
    let truth = Truth::new(height, rotate_deg, &plan.optics, run.lights, &done)?;
    bar.finish_and_clear();

    let bar = stage(console, "errors of the candidates");
    let mut measured = 0;
    let budget_de = run.limits.budget_de;
    let states = search(&candidates, budget_de, &mut |candidate| {
        if stopped() {
            interrupt::exit();
        }
        measured += 1;
        bar.set_message(format!("{measured} measured, now {}", candidate.variant.name));
        bar.tick();
        let placement = Placement { height, rotate_deg, variant: &candidate.variant };
        Ok::<_, anyhow::Error>(truth.measure(placement, budget_de))
    })?;
    let texts = Variant::texts(&plan.optics);
    bar.set_message("colours of the baseline");
    bar.tick();
    let errors = truth.of(Placement { height, rotate_deg, variant: &texts })?;
    bar.finish_and_clear();

    console.note("now the times of the best candidates");
    let bar = progress::bar(STEPS, "times");
    let chosen = to_time(&candidates, &states, budget_de);
    let timed: Vec<Timee<'_>> = chosen
        .into_iter()
        .map(|place| Timee {
            place,
            candidate: &candidates[place],
            within: states[place].worst_p95().is_some_and(|p95| p95 <= budget_de),
        })
        .collect();
    let scene = Scene { height, rotate_deg, light: run.lights[0], unchecked: args.unchecked };
    let share = |share: f64| bar.set_position((STEPS as f64 * share) as u64);
    let (times, time) = timing::times(gpu, &scene, args, &timed, &share, &stopped);
    bar.finish_and_clear();
    if stopped() {
        interrupt::exit();
    }
    let cost = Form::new(&texts, height)?.cost();
    Ok(Results { candidates, states, lost, times, baseline: Baseline { errors, time, cost } })
}

/// Announces a stage of the work, and shows that it goes on.
fn stage(console: &Console, what: &str) -> ProgressBar {
    console.note(&format!("now {what}"));
    let bar = ProgressBar::new_spinner();
    bar.set_message(what.to_owned());
    bar.enable_steady_tick(TICK);
    bar
}

/// Takes candidates out whose errors would take too much memory to compute.
fn affordable(
    candidates: Vec<Candidate>,
    height: &HeightField,
    budget: u64,
) -> (Vec<Candidate>, Vec<Lost>) {
    let (mut kept, mut lost) = (Vec::new(), Vec::new());
    for candidate in candidates {
        let Candidate { variant, on, .. } = &candidate;
        let memory = Memory::new(height, variant, on, rayon::current_num_threads());
        let needed = memory::around_bytes(height.byte_count(), 1) + memory.to_evaluate();
        match memory::within_budget(&variant.name, needed, budget) {
            Ok(()) => kept.push(candidate),
            Err(error) => lost.push(lose(&candidate, Verdict::Large, error.to_string())),
        }
    }
    (kept, lost)
}

/// Writes the records in place of those of an earlier run of the same search, and draws the front.
fn keep(folder: &Path, records: &[Tune], console: &Console) -> Result<()> {
    let Some(first) = records.first() else { return Ok(()) };
    let same = |record: &Record| match record {
        Record::Tune(tune) => {
            let place = |t: &Tune| {
                let asked =
                    (t.budget_de.to_bits(), t.fits.clone(), t.max_table_mib.map(f64::to_bits));
                (t.surface.clone(), t.backend.clone(), t.adapter.clone(), asked)
            };
            place(tune) == place(first)
        }
        _ => false,
    };
    let (mut log, _) = Log::begin(folder, &|text| console.note(text), same)?;
    records.iter().try_for_each(|record| log.append(&Record::Tune(record.clone())))?;
    if let Some(picture) = front_picture(records) {
        let name = format!("tune-{}-{}-de{}.svg", first.surface, first.backend, first.budget_de);
        write_whole(&folder.join("pictures").join(name), picture.as_bytes())?;
    }
    Ok(())
}
