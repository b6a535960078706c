//! The command itself.

use std::cell::Cell;
use std::path::Path;

use anyhow::{Result, bail};
use diffraction_cli::Outcome;
use diffraction_cli::args::Exposure;
use diffraction_cli::console::{Console, Errors};
use diffraction_cli::{interrupt, progress};
use diffraction_shaders::error::shell_path;
use diffraction_shaders::hash::sha256;
use diffraction_shaders::input;
use diffraction_shaders::light::Lights;
use diffraction_shaders::plan::Variant;
use diffraction_shaders::variant::Arguments;
use glam::DVec3;

use super::sink::Recorder;
use super::{Args, summary};
use crate::compare::{Job, Shine, Sink, run as compare, steps};
use crate::drivers::routes::{self, Route};
use crate::process::watched::{self, Crash, Place};
use crate::results::{Gap, Lit, Log, Record};

pub(super) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let plan = args.plan.read(console)?;
    let variants: Vec<Variant> = plan.select(&args.variant)?;
    let mut surfaces = plan.surfaces.clone();
    if !args.surface.is_empty() {
        surfaces = args
            .surface
            .iter()
            .map(|name| plan.surface(name).cloned())
            .collect::<Result<_, _>>()?;
    }
    let lights = args.lights.as_deref().map(|path| read(path, &variants, console)).transpose()?;
    // before anything is written: a named route may be missing
    let (routes, missing) = open(&args.route)?;
    let has_waited = Cell::new(false);
    let waiting = |text: &str| {
        has_waited.set(true);
        console.note(text);
    };
    let crashes = &watched::child::history().crashes;
    let cut_short = |record: &Record| match record {
        Record::Gap(_) => true,
        // all of the variant that was drawn is compared again
        Record::Compare(c) => crashes.iter().any(|Crash { place, .. }| {
            place.surface.as_ref() == Some(&c.surface)
                && place.variant.as_ref() == Some(&c.variant)
                && place.light.map_or(matches!(c.light, Lit::Lights(_)), |angles| {
                    c.light == Lit::Direction(angles)
                })
        }),
        _ => false,
    };
    let mine = |record: &Record| match record {
        // the results of a run that was there at the same time are wanted, too
        _ if has_waited.get() => false,
        // missing routes are tried again: they may be there now
        Record::Gap(_) => true,
        Record::Compare(_) | Record::Control(_) | Record::Energy(_) => !args.resume,
        _ => false,
    };
    let (log, known) = match crashes.is_empty() {
        true => Log::begin(&args.out, &waiting, mine)?,
        false => Log::go_on(&args.out, &waiting, cut_short)?,
    };
    if has_waited.get() {
        console
            .note("the results of the other run stay; what it has compared is not compared again");
    }
    interrupt::install()?;
    let mut recorder = Recorder::new(&args.out, log, known, args.json, console);
    for crash in crashes {
        let Place { route, surface, variant, .. } = crash.place.clone();
        let reason = crash.reason();
        recorder.record(Record::Gap(Gap { route, surface, variant, reason, failed: true }))?;
    }
    missing.into_iter().try_for_each(|gap| recorder.record(Record::Gap(gap)))?;
    let exposure = match args.exposure {
        Exposure::Auto => None,
        Exposure::Value(value) => Some(value),
    };
    let shines: Vec<Shine<'_>> = match &lights {
        Some((name, lights)) => vec![Shine::Lights(name, lights)],
        None => {
            let angles = args.light.iter().map(|light| [light.theta_deg, light.phi_deg]);
            angles.map(Shine::Direction).collect()
        }
    };
    let request = Job {
        surfaces: &surfaces,
        variants: &variants,
        routes: &routes,
        lights: &shines,
        size: args.size as usize,
        exposure,
        subset: args.subset,
        memory: args.memory.budget(),
    };
    recorder.bar = progress::bar(steps(&request), "comparing");
    let done = compare(&request, &mut recorder);
    recorder.bar.finish_and_clear();
    done?;
    let (text, outcome) = summary::summary(&recorder.records);
    if !args.json {
        console.data(&text)?;
    }
    console.note(&format!(
        "records and pictures are in {}; next: cargo xtask report {}",
        args.out.display(),
        shell_path(&args.out)
    ));
    Ok(outcome)
}

/// The lights of a file with their name, which has a part of their hash. It is an error if no variant can have functions for
/// them all.
fn read(path: &Path, variants: &[Variant], console: &Console) -> Result<(String, Lights)> {
    let lights = input::read_lights(path).map_err(Errors)?;
    lights.notes.iter().for_each(|note| console.note(note));
    for light in lights.with_size() {
        let calls = Arguments::under(light, DVec3::Z);
        let has = |v: &Variant| {
            let words = calls.iter().map(|(call, _)| call.kind().word());
            words.into_iter().all(|word| word.is_some_and(|word| v.has_function(word)))
        };
        if calls.is_empty() || !variants.iter().any(has) {
            bail!(
                "--lights {}: none of the variants has a function for a light of kind {:?}; these are functions of mode = \"orders\"",
                path.display(),
                light.kind()
            );
        }
    }
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into());
    let hash = sha256(format!("{lights:?}").as_bytes());
    Ok((format!("{name} {}", &hash[..8]), lights))
}

/// Open routes, and gaps for those that are missing.
type Opened = (Vec<Box<dyn Route>>, Vec<Gap>);

/// Opens the wanted routes. A missing route is a gap, but an error if it was named.
fn open(wanted: &[String]) -> Result<Opened> {
    let drivers: Vec<String> = wanted.iter().filter(|name| *name != "twin").cloned().collect();
    let (mut open, mut missing) = (Vec::new(), Vec::new());
    if drivers.is_empty() && !wanted.is_empty() {
        return Ok((open, missing));
    }
    for found in routes::open(&drivers)? {
        match found.route {
            Ok(route) => open.push(route),
            // recorded as a crash
            Err(_) if watched::child::history().refusal(&found.name).is_some() => {}
            Err(error) if drivers.is_empty() => missing.push(Gap {
                route: found.name,
                surface: None,
                variant: None,
                reason: error.to_string(),
                failed: false,
            }),
            Err(error) => return Err(error.into()),
        }
    }
    Ok((open, missing))
}
