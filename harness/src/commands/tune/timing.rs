//! Times of candidates on an adapter.

use std::collections::BTreeMap;
use std::time::Duration;

use anyhow::Result;
use diffraction_shaders::error;
use diffraction_shaders::plan::Variant;

use crate::bench::clock::SystemClock;
use crate::bench::driver::{Case, Scene, Under, measure};
use crate::bench::result::{Place, Timed, bench};
use crate::bench::rounds::{Rules, ratios};
use crate::bench::stats::{interval, median};
use crate::drivers::gpu::{Backend, Gpu};
use crate::process::watched::{Place as Watched, child::enter};
use crate::results::Time;
use crate::tune::Candidate;
use crate::tune::verdict::time;

use super::Args;
use crate::commands::bench::Interface;

/// Maximum bytes of tables on the device at the same time. Candidates that do not fit together are drawn in groups.
const GROUP_BYTES: u64 = 1 << 30;

/// A candidate to be timed.
pub(super) struct Timee<'a> {
    /// Its index among the candidates.
    pub(super) place: usize,
    pub(super) candidate: &'a Candidate,
    /// Whether it is within the budget and so may win.
    pub(super) within: bool,
}

/// Times, or what went wrong, by the indices of candidates.
pub(super) type Times = BTreeMap<usize, Result<Time, String>>;

/// Opens the adapter that the options select. Without --backend: a Vulkan adapter, else one of GL.
pub(super) fn open(args: &Args) -> Result<Gpu> {
    let adapter = args.adapter.as_deref();
    let backend = match args.backend {
        None => {
            let vulkan = on(Backend::Vulkan, adapter);
            return match vulkan.or_else(|error| on(Backend::Gl, adapter).map_err(|_| error)) {
                Ok(gpu) => Ok(gpu),
                Err(error) => Err(error.into()),
            };
        }
        Some(Interface::Vulkan) => Backend::Vulkan,
        Some(Interface::Gl) => Backend::Gl,
        Some(Interface::Metal) => Backend::Metal,
        Some(Interface::Dx12) => Backend::Dx12,
    };
    Ok(on(backend, adapter)?)
}

/// Opens an adapter, and says so.
fn on(backend: Backend, adapter: Option<&str>) -> error::Result<Gpu> {
    enter(Watched { route: backend.name().to_owned(), ..Watched::default() });
    Gpu::open(backend, adapter)
}

/// Draws candidates in turns with `texts`. `progress` gets the share of the work done; `stop` is called before every draw.
/// Returns the times, and the time of the baseline in the first group.
pub(super) fn times(
    gpu: &Gpu,
    scene: &Scene<'_>,
    args: &Args,
    all: &[Timee<'_>],
    progress: &dyn Fn(f64),
    stop: &dyn Fn() -> bool,
) -> (Times, Option<Time>) {
    let Some(first) = all.first() else { return (Times::new(), None) };
    let texts = Variant::texts(&first.candidate.variant.optics);
    let size = args.size as usize;
    let case = |variant: &Variant| {
        let variant = Box::new(variant.clone());
        Case::Map { variant, height: None, frame: [size; 2], under: Under::Direction }
    };
    let rules = Rules::standard(Duration::from_secs_f64(args.seconds));
    let clock = SystemClock::new();
    let place = Place {
        surface: args.surface.surface.clone(),
        backend: gpu.info().backend.name().to_owned(),
        adapter: gpu.info().name.clone(),
        light: scene.light,
    };
    let groups = groups(all);
    let (mut found, mut baseline) = (Times::new(), None);
    for (number, group) in groups.iter().enumerate() {
        let variants = group.iter().map(|timee| &timee.candidate.variant);
        let cases: Vec<Case> = std::iter::once(&texts).chain(variants).map(case).collect();
        let drawn = group.iter().map(|timee| timee.candidate.variant.name.as_str());
        enter(Watched {
            route: format!("{}:{}", place.backend, place.adapter),
            surface: Some(place.surface.clone()),
            variant: Some(
                std::iter::once(texts.name.as_str()).chain(drawn).collect::<Vec<_>>().join(", "),
            ),
            light: None,
        });
        let share = |share: f64| progress((number as f64 + share) / groups.len() as f64);
        let measured = measure(gpu, scene, &cases, &clock, &rules, &share, stop);
        let mut outcomes = measured.cases;
        let of = |timed: &Timed, texts: &Timed| {
            bench(&place, measured.timing, timed, Some(texts)).as_ref().and_then(time)
        };
        let drawn = outcomes.drain(1..).collect::<Vec<_>>();
        let Some(Ok(texts)) = outcomes.pop() else {
            let why = "the baseline could not be drawn".to_owned();
            found.extend(group.iter().map(|timee| (timee.place, Err(why.clone()))));
            continue;
        };
        baseline = baseline.or_else(|| of(&texts, &texts));
        let mut here: Vec<Result<Time, String>> = drawn
            .iter()
            .map(|outcome| match outcome {
                Ok(timed) => of(timed, &texts).ok_or_else(|| "no round was measured".to_owned()),
                Err(error) => Err(error.to_string()),
            })
            .collect();
        if groups.len() == 1 {
            let within = |i: &usize| group[*i].within;
            paces(&(0..group.len()).filter(within).collect::<Vec<_>>(), &drawn, &mut here);
            // candidates with equal times are drawn once more, without the slow baseline
            let close: Vec<usize> =
                (0..group.len()).filter(|i| within(i) && ties(&here[*i])).collect();
            if close.len() > 1 {
                let cases: Vec<Case> =
                    close.iter().map(|i| case(&group[*i].candidate.variant)).collect();
                let again = measure(gpu, scene, &cases, &clock, &rules, &|_| (), stop).cases;
                let mut times: Vec<_> = close.iter().map(|i| here[*i].clone()).collect();
                paces(&(0..close.len()).collect::<Vec<_>>(), &again, &mut times);
                close.iter().zip(times).for_each(|(i, time)| here[*i] = time);
            }
        }
        found.extend(group.iter().zip(here).map(|(timee, time)| (timee.place, time)));
    }
    (found, baseline)
}

/// Splits the candidates into as few groups as memory allows.
fn groups<'a, 'b>(all: &'a [Timee<'b>]) -> Vec<Vec<&'a Timee<'b>>> {
    let mut groups: Vec<(u64, Vec<&Timee<'_>>)> = Vec::new();
    for timee in all {
        let bytes = timee.candidate.table_bytes();
        match groups.last_mut() {
            Some((sum, group)) if *sum + bytes <= GROUP_BYTES => {
                *sum += bytes;
                group.push(timee);
            }
            _ => groups.push((bytes, vec![timee])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// Compares every time with the time of the fastest candidate that may win, round by round.
fn paces(may_win: &[usize], drawn: &[error::Result<Timed>], here: &mut [Result<Time, String>]) {
    let Some(Ok(any)) = may_win.iter().map(|i| &drawn[*i]).find(|timed| timed.is_ok()) else {
        return;
    };
    let speed = |timed: &Timed| median(&ratios(&any.samples, &timed.samples)).unwrap_or(0.0);
    let sound = may_win.iter().filter_map(|i| drawn[*i].as_ref().ok());
    let Some(fastest) = sound.max_by(|a, b| speed(a).total_cmp(&speed(b))) else { return };
    for (timed, time) in drawn.iter().zip(here) {
        if let (Ok(timed), Ok(time)) = (timed, time) {
            time.pace = interval(&ratios(&fastest.samples, &timed.samples));
        }
    }
}

fn ties(time: &Result<Time, String>) -> bool {
    time.as_ref().is_ok_and(|time| time.pace.is_some_and(|pace| pace[1] >= 1.0))
}
