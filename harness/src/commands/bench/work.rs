//! The groups of variants to measure, and their order.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Result, bail};
use diffraction_cli::console::Console;
use diffraction_cli::{Outcome, interrupt, memory, progress};
use diffraction_shaders::input;
use diffraction_shaders::plan::{LightFunction, SurfaceSpec, Variant};
use diffraction_shaders::surface::{self, Surface};
use diffraction_shaders::survey::memory::Memory;
use diffraction_shaders::variant::Form;
use indicatif::ProgressBar;

use super::output::Output;
use super::timed::{Point, TimedVariant};
use super::{Args, adapters};
use crate::bench::clock::SystemClock;
use crate::bench::driver::{Case, Group, Scene, Under, measure};
use crate::bench::result::{self, Place, bench};
use crate::bench::rounds::Rules;
use crate::bench::scaling::{self, Swept};
use crate::bench::stats::median;
use crate::bench::yardstick::Yardstick;
use crate::drivers::gpu::{AdapterInfo, Gpu};
use crate::process::watched;
use crate::results::Gap;

/// Maximum number of variants whose tables are on the device at the same time, besides the baseline.
const GROUP: usize = 6;

/// Steps of the progress bar for a group.
const STEPS: usize = 1000;

/// What stays the same during a run.
struct Run<'a> {
    args: &'a Args,
    rules: Rules,
    clock: SystemClock,
    stop: &'a AtomicBool,
    bar: ProgressBar,
    baseline: Variant,
}

/// A surface on an adapter, with the variants that can be measured there.
struct Site<'a> {
    gpu: Gpu,
    scene: Scene<'a>,
    place: Place,
    baseline: Variant,
    variants: Vec<Variant>,
    /// Set for the first group on an adapter, whose clock is reported.
    info: Option<&'a AdapterInfo>,
}

pub(super) fn run(args: &Args, budget: Duration, console: &Console) -> Result<Outcome> {
    let plan = args.plan.read(console)?;
    let specs: Vec<SurfaceSpec> = match args.surface.as_slice() {
        [] => plan.surfaces.clone(),
        names => names.iter().map(|n| plan.surface(n).cloned()).collect::<Result<_, _>>()?,
    };
    let variants = plan.select(&args.variant)?;
    let baseline = plan.variant(Some(&args.baseline))?;
    for what in yardsticks(args) {
        if variants.iter().any(|variant| variant.name == what.name()) {
            bail!("--{0}: the plan has a variant of the same name {0}; rename it", what.name());
        }
    }
    let mut output = Output::open(args, console)?;
    let mut surfaces = Vec::new();
    for spec in specs {
        let surface = input::load_surface(&spec)?;
        surface.notes.iter().for_each(|note| console.note(note));
        surfaces.push((spec, surface));
    }
    affordable(args, &surfaces, &variants)?;
    let history = watched::child::history();
    output.go_on(history)?;
    let adapters = adapters::chosen(args, &mut output)?;
    if adapters.is_empty() && history.crashes.is_empty() {
        bail!("there is no adapter to measure on");
    }
    let stop = interrupt::flag()?;
    let groups = match args.scaling {
        true => variants.len() * Swept::ALL.len(),
        false => variants.len().div_ceil(GROUP).max(1),
    };
    let bar = progress::bar(STEPS * groups * surfaces.len() * adapters.len(), "measuring");
    output.beside(&bar);
    let rules = Rules::standard(budget);
    let run = Run { args, rules, clock: SystemClock::new(), stop: &stop, bar, baseline };
    for info in &adapters {
        let route = format!("{}:{}", info.backend, info.name);
        if history.refusal(&route).is_some() || output.is_done(&route) {
            run.bar.inc((STEPS * groups * surfaces.len()) as u64);
            continue;
        }
        for (index, (spec, surface)) in surfaces.iter().enumerate() {
            if run.stopped() {
                break;
            }
            let first = (index == 0).then_some(info);
            run.site(info, first, spec, surface, &variants, &mut output)?;
        }
        if !run.stopped() {
            output.done(route);
        }
    }
    run.bar.finish_and_clear();
    output.finish(!run.stopped())?;
    if run.stopped() {
        interrupt::exit();
    }
    Ok(if output.failed() { Outcome::Findings } else { Outcome::Done })
}

/// Refuses variants that take too much memory. The tables of a group are on the device together.
fn affordable(
    args: &Args,
    surfaces: &[(SurfaceSpec, Surface)],
    variants: &[Variant],
) -> Result<()> {
    let held = surfaces.iter().map(|(_, surface)| surface.field.byte_count()).sum();
    for (spec, surface) in surfaces {
        let placed = variants.iter().filter_map(|variant| variant.on(spec)?.ok());
        // a variant that cannot be built is a gap, later
        let known: Vec<(String, Memory)> = placed
            .filter_map(|v| memory::of(&surface.field, &v).ok().map(|memory| (v.name, memory)))
            .collect();
        let largest = known.iter().map(|(_, memory)| memory.table_bytes).max().unwrap_or(0);
        let others = GROUP.min(known.len().saturating_sub(1)) as u64 * largest;
        for (name, memory) in &known {
            args.memory.check(&spec.name, name, held, memory.to_check_and_draw() + others)?;
        }
    }
    Ok(())
}

impl Run<'_> {
    fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn site(
        &self,
        info: &AdapterInfo,
        first: Option<&AdapterInfo>,
        spec: &SurfaceSpec,
        surface: &Surface,
        variants: &[Variant],
        output: &mut Output<'_>,
    ) -> Result<()> {
        let light = [self.args.light.theta_deg, self.args.light.phi_deg];
        let place = Place {
            surface: spec.name.clone(),
            backend: info.backend.name().to_owned(),
            adapter: info.name.clone(),
            light,
        };
        watched::child::enter(watched::Place {
            route: format!("{}:{}", info.backend, info.name),
            surface: Some(spec.name.clone()),
            ..watched::Place::default()
        });
        // each surface has a device of its own: a lost device ends only its surface
        let gpu = match adapters::open(info) {
            Ok(gpu) => gpu,
            Err(error) => return output.gap(gap(&place, None, &error.to_string(), false)),
        };
        let Some(Ok(baseline)) = self.baseline.on(spec) else {
            let why = "the baseline cannot be built on this surface";
            return output.gap(gap(&place, Some(&self.baseline.name), why, false));
        };
        let mut fit = Vec::new();
        for variant in variants {
            let Some(here) = variant.on(spec) else { continue };
            let nm = variant.wavelengths.min_nm;
            let pitch = surface.field.check_pitch(&surface::subject(spec), nm);
            match here.and_then(|here| pitch.map(|()| here)) {
                Ok(here) => fit.push(here),
                Err(e) => output.gap(gap(&place, Some(&variant.name), &e.to_string(), false))?,
            }
        }
        let scene = Scene {
            height: &surface.field,
            rotate_deg: spec.rotate_deg,
            light,
            unchecked: self.args.unchecked,
        };
        let mut site = Site { gpu, scene, place, baseline, variants: fit, info: first };
        if self.args.scaling {
            self.scaling(&mut site, output)
        } else {
            self.times(&mut site, output)
        }
    }

    fn times(&self, site: &mut Site<'_>, output: &mut Output<'_>) -> Result<()> {
        let frame = self.args.size.0;
        let lit = |variant: &Variant, under| {
            let variant = Box::new(variant.clone());
            Case::Map { variant, height: None, frame, under }
        };
        let map = |variant: &Variant| lit(variant, Under::Direction);
        let asked = [
            self.args.disc_deg.map(|deg| (Under::Disc(deg), LightFunction::Disc)),
            self.args.studio.map(|studio| (Under::Studio(studio), LightFunction::Environment)),
        ];
        let mut others = Vec::new();
        for variant in &site.variants {
            if variant.name != site.baseline.name {
                others.push(map(variant));
            }
            for (under, word) in asked.into_iter().flatten() {
                if variant.has_function(word) {
                    others.push(lit(variant, under));
                } else {
                    let why = format!("has no function for a light of kind {:?}", word.as_str());
                    output.gap(gap(&site.place, Some(&variant.name), &why, false))?;
                }
            }
        }
        let mut groups: Vec<Vec<Case>> = others.chunks(GROUP).map(<[Case]>::to_vec).collect();
        if groups.is_empty() {
            groups.push(Vec::new());
        }
        for what in yardsticks(self.args) {
            let optics = Box::new(site.baseline.optics.clone());
            groups[0].push(Case::Yardstick { what, optics, frame });
        }
        if let Some(studio) = self.args.studio.filter(|_| self.args.ggx) {
            let has = |variant: &&Variant| variant.has_function(LightFunction::Environment);
            let lender = site.variants.iter().find(has);
            groups[0].extend(lender.map(|variant| lit(variant, Under::GgxIn(studio))));
        }
        for (number, group) in groups.into_iter().enumerate() {
            if self.stopped() {
                break;
            }
            let cases: Vec<Case> = std::iter::once(map(&site.baseline)).chain(group).collect();
            let group = self.group(site, &cases, output);
            let baseline = group.cases.first().and_then(|first| first.as_ref().ok());
            for (index, (case, outcome)) in cases.iter().zip(&group.cases).enumerate() {
                // later groups draw the same baseline again
                if index == 0 && number > 0 {
                    continue;
                }
                match outcome {
                    Ok(timed) => {
                        if let Some(record) = bench(&site.place, group.timing, timed, baseline) {
                            output.row(TimedVariant { record, fetches: timed.fetches })?;
                        }
                    }
                    Err(error) => {
                        output.gap(gap(
                            &site.place,
                            Some(&case.name()),
                            &error.to_string(),
                            true,
                        ))?;
                    }
                }
            }
        }
        Ok(())
    }

    fn scaling(&self, site: &mut Site<'_>, output: &mut Output<'_>) -> Result<()> {
        for variant in &std::mem::take(&mut site.variants) {
            for axis in Swept::ALL {
                if self.stopped() {
                    return Ok(());
                }
                let surface = site.scene.height;
                let points = axis.points(variant, self.args.size.0, surface)?;
                if points.is_empty() {
                    let why =
                        format!("mode {} does not read {}", variant.mode.as_str(), axis.name());
                    output.gap(gap(&site.place, Some(&variant.name), &why, false))?;
                    self.bar.inc(STEPS as u64);
                    continue;
                }
                let mut possible = Vec::new();
                for point in points {
                    let height = point.height.as_ref().unwrap_or(surface);
                    match Form::new(&point.variant, height) {
                        Ok(_) => possible.push(point),
                        Err(error) => {
                            let why = format!("{} {}: {error}", axis.name(), point.value);
                            output.gap(gap(&site.place, Some(&variant.name), &why, false))?;
                        }
                    }
                }
                let points = possible;
                let case = |point: &scaling::Point| Case::Map {
                    variant: Box::new(point.variant.clone()),
                    height: point.height.clone().map(Box::new),
                    frame: point.frame,
                    under: Under::Direction,
                };
                let cases: Vec<Case> = points.iter().map(case).collect();
                let group = self.group(site, &cases, output);
                let mut measured = Vec::new();
                for (point, outcome) in points.iter().zip(&group.cases) {
                    match outcome {
                        Ok(timed) => {
                            let record =
                                result::scaling(&site.place, axis.name(), point.value, timed);
                            let cpu_ms = median(&timed.samples.cpu_ms).unwrap_or_default();
                            let point = |record| Point { record, work: point.work, cpu_ms };
                            measured.extend(record.map(point));
                        }
                        Err(error) => {
                            let why = format!("{} {}: {error}", axis.name(), point.value);
                            output.gap(gap(&site.place, Some(&variant.name), &why, true))?;
                        }
                    }
                }
                output.scaling(axis, measured)?;
            }
        }
        Ok(())
    }

    fn group(&self, site: &mut Site<'_>, cases: &[Case], output: &Output<'_>) -> Group {
        let names: Vec<String> = cases.iter().map(Case::name).collect();
        watched::child::enter(watched::Place {
            route: format!("{}:{}", site.place.backend, site.place.adapter),
            surface: Some(site.place.surface.clone()),
            variant: Some(names.join(", ")),
            light: None,
        });
        let begun = self.bar.position();
        let share = |share: f64| self.bar.set_position(begun + (STEPS as f64 * share) as u64);
        let stop = || self.stopped();
        let group = measure(&site.gpu, &site.scene, cases, &self.clock, &self.rules, &share, &stop);
        if let Some(info) = site.info.take() {
            output.note(&adapters::clock(info, &group));
        }
        group
    }
}

/// The yardsticks to draw beside the variants.
fn yardsticks(args: &Args) -> Vec<Yardstick> {
    let asked = [(args.empty, Yardstick::Empty), (args.ggx, Yardstick::Ggx)];
    asked.into_iter().filter(|(on, _)| *on).map(|(_, what)| what).collect()
}

fn gap(place: &Place, variant: Option<&str>, reason: &str, failed: bool) -> Gap {
    Gap {
        route: format!("{}:{}", place.backend, place.adapter),
        surface: Some(place.surface.clone()),
        variant: variant.map(str::to_owned),
        reason: reason.to_owned(),
        failed,
    }
}
