//! The adapter, and times on it.

use std::collections::BTreeMap;
use std::time::Duration;

use anyhow::Result;
use diffraction_shaders::bench::clock::SystemClock;
use diffraction_shaders::bench::driver::{Case, Scene, measure};
use diffraction_shaders::bench::result::{Place, Timed, bench};
use diffraction_shaders::bench::rounds::Rules;
use diffraction_shaders::plan::Variant;
use diffraction_shaders::record::Time;
use diffraction_shaders::runner::gpu::{Backend, Gpu};
use diffraction_shaders::tune::verdict::time;

use super::Args;
use crate::bench::Interface;

/// Candidates beside the baseline whose tables are on the device at the same time.
const GROUP: usize = 8;

/// Times by the places of what was timed, or what went wrong.
pub(super) type Times = BTreeMap<usize, Result<Time, String>>;

/// The adapter that the flags mean; without an interface Vulkan's, else GL's.
pub(super) fn open(args: &Args) -> Result<Gpu> {
    let adapter = args.adapter.as_deref();
    let backend = match args.backend {
        None => {
            let vulkan = Gpu::open(Backend::Vulkan, adapter);
            return match vulkan.or_else(|error| Gpu::open(Backend::Gl, adapter).map_err(|_| error))
            {
                Ok(gpu) => Ok(gpu),
                Err(error) => Err(error.into()),
            };
        }
        Some(Interface::Vulkan) => Backend::Vulkan,
        Some(Interface::Gl) => Backend::Gl,
        Some(Interface::Metal) => Backend::Metal,
        Some(Interface::Dx12) => Backend::Dx12,
    };
    Ok(Gpu::open(backend, adapter)?)
}

/// Draws variants in turns with `texts`, in groups. `progress` is told the share that is done, `stop` is asked before
/// every draw. Gives the times, and that of the baseline in the first group.
pub(super) fn times(
    gpu: &Gpu,
    scene: &Scene<'_>,
    args: &Args,
    variants: &[(usize, &Variant)],
    progress: &dyn Fn(f64),
    stop: &dyn Fn() -> bool,
) -> (Times, Option<Time>) {
    let Some((_, first)) = variants.first() else { return (Times::new(), None) };
    let size = args.size as usize;
    let case = |variant: &Variant| Case::Map { variant: Box::new(variant.clone()), size };
    let rules = Rules::standard(Duration::from_secs_f64(args.seconds));
    let clock = SystemClock::new();
    let place = Place {
        surface: args.surface.surface.clone(),
        backend: gpu.info().backend.name().to_owned(),
        adapter: gpu.info().name.clone(),
        light: scene.light,
    };
    let groups = variants.len().div_ceil(GROUP) as f64;
    let (mut all, mut baseline) = (Times::new(), None);
    for (number, group) in variants.chunks(GROUP).enumerate() {
        let texts = Variant::texts(&first.optics);
        let cases: Vec<Case> =
            std::iter::once(&texts).chain(group.iter().map(|(_, v)| *v)).map(case).collect();
        let share = |share: f64| progress((number as f64 + share) / groups);
        let measured = measure(gpu, scene, &cases, &clock, &rules, &share, stop);
        let mut outcomes = measured.cases.into_iter();
        let Some(Ok(texts)) = outcomes.next() else {
            let why = "the baseline could not be drawn".to_owned();
            all.extend(group.iter().map(|(place, _)| (*place, Err(why.clone()))));
            continue;
        };
        let of = |timed: &Timed| {
            bench(&place, measured.timing, timed, Some(&texts)).as_ref().and_then(time)
        };
        baseline = baseline.or_else(|| of(&texts));
        for ((at, _), outcome) in group.iter().zip(outcomes) {
            let time = match &outcome {
                Ok(timed) => of(timed).ok_or_else(|| "no round was measured".to_owned()),
                Err(error) => Err(error.to_string()),
            };
            all.insert(*at, time);
        }
    }
    (all, baseline)
}
