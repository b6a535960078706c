//! Groups of variants on one adapter.

use glam::DVec3;
use serde_json::Value;

use super::clock::{Clock, ms};
use super::result::{Timed, settings};
use super::rounds::{self, Drawn, Executor, Rules, Samples, Timing};
use crate::error::Result;
use crate::height::HeightField;
use crate::optics::direction;
use crate::plan::{Auto, Mode, Optics, Variant};
use crate::resolve::resolve;
use crate::runner::gpu::{Gpu, Pipeline};
use crate::runner::{Prepared, Subject, params};
use crate::tables::Table;
use crate::template::Sources;

/// Name of the shader that computes nothing but the gain: the floor below which a frame cannot fall.
pub const EMPTY: &str = "empty";

/// In place of a mode's template: the gain of the pixel and no texel.
const EMPTY_TEMPLATE: &str = "
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    return vec3f(gain(wi, wr));
}
";

/// Pixels along a side of the first draw, which makes the driver compile.
const FIRST_DRAW: u32 = 8;

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The heights.
    pub height: &'a HeightField,
    /// Rotation of the surface about its normal, degrees.
    pub rotate_deg: f64,
    /// Direction of the light, theta and phi in degrees.
    pub light: [f64; 2],
}

/// A subject of a group.
#[derive(Clone, Debug, PartialEq)]
pub enum Case {
    /// A variant's map.
    Map {
        /// The variant.
        variant: Box<Variant>,
        /// Pixels along a side.
        size: usize,
    },
    /// The map of [`EMPTY`].
    Empty {
        /// Decide the gain.
        optics: Box<Optics>,
        /// Pixels along a side.
        size: usize,
    },
}

/// What was measured of a group, in the order of its cases.
#[derive(Debug)]
pub struct Group {
    /// The clock of all times.
    pub timing: Timing,
    /// Greatest difference of time stamps from the wall while warming up, relative; none where there are no stamps.
    pub disagreement: Option<f64>,
    /// The times, or what went wrong.
    pub cases: Vec<Result<Timed>>,
}

/// Builds the pipelines of a group and draws them in turns, see [`rounds::measure`]. Ratios are to the first case.
pub fn measure(
    gpu: &Gpu,
    scene: &Scene<'_>,
    cases: &[Case],
    clock: &dyn Clock,
    rules: &Rules,
    progress: &dyn Fn(f64),
    stop: &dyn Fn() -> bool,
) -> Group {
    let built: Vec<Result<Built>> =
        cases.iter().map(|case| build(gpu, scene, case, clock)).collect();
    let mut subjects: Vec<Box<dyn Executor + '_>> =
        built.iter().map(|built| Box::new(Subjected(built)) as Box<dyn Executor>).collect();
    let measured = rounds::measure(&mut subjects, clock, rules, progress, stop);
    drop(subjects);
    let disagreement = measured.samples.iter().flatten().filter_map(|s| s.disagreement);
    let disagreement = disagreement.reduce(f64::max);
    // an error of building comes before the one of drawing what was not built
    let timed = |(built, samples): (Result<Built>, Result<Samples>)| {
        let built = built?;
        Ok(Timed { samples: samples?, ..built.timed })
    };
    let cases = built.into_iter().zip(measured.samples).map(timed).collect();
    Group { timing: measured.timing, disagreement, cases }
}

/// A pipeline with what is known of it.
struct Built {
    pipeline: Pipeline,
    params: [f32; 8],
    timed: Timed,
}

struct Subjected<'a>(&'a Result<Built>);

impl Executor for Subjected<'_> {
    fn draw(&mut self, frames: usize) -> Result<Drawn> {
        let built = match self.0 {
            Ok(built) => built,
            Err(error) => {
                return Err(crate::error::Error::new(
                    error.stage(),
                    error.subject(),
                    "was not built",
                ));
            }
        };
        let size = built.timed.size as u32;
        let times = built.pipeline.frames(size, size, bytemuck::bytes_of(&built.params), frames)?;
        Ok(Drawn { wall: times.wall, stamps: times.stamps })
    }
}

fn build(gpu: &Gpu, scene: &Scene<'_>, case: &Case, clock: &dyn Clock) -> Result<Built> {
    let Scene { height, rotate_deg, light } = *scene;
    let (prepared, size) = match case {
        Case::Map { variant, size } => {
            (Prepared::new(Subject { height, rotate_deg, variant })?, *size)
        }
        Case::Empty { optics, size } => return build_empty(gpu, scene, optics, *size, clock),
    };
    let variant = prepared.subject.variant;
    let cost = prepared.resolved.cost;
    let timed = Timed {
        variant: variant.name.clone(),
        settings: settings(variant),
        size,
        pipeline_ms: 0.0,
        table_bytes: cost.table_bytes,
        fetches: cost.fetches_mean,
        samples: Samples::default(),
    };
    compile(gpu, &prepared, direction(light[0], light[1]), timed, clock)
}

fn build_empty(
    gpu: &Gpu,
    scene: &Scene<'_>,
    optics: &Optics,
    size: usize,
    clock: &dyn Clock,
) -> Result<Built> {
    let texts = Variant::texts(optics);
    let resolved = resolve(&Variant { terms: Auto::Value(1), ..texts.clone() }, scene.height)?;
    // the mode whose template needs nothing of the others
    let variant = Variant { name: EMPTY.to_owned(), mode: Mode::Gems, ..texts };
    let mut sources = Sources::builtin();
    sources.0.insert("gems".to_owned(), EMPTY_TEMPLATE.to_owned());
    let prepared = Prepared {
        // turning a surface that is not read takes its table
        subject: Subject { height: scene.height, rotate_deg: 0.0, variant: &variant },
        sources,
        resolved,
        terms: Table::ABSENT,
        spectrum: Table::ABSENT,
        coefficients: Table::ABSENT,
    };
    let timed = Timed {
        variant: EMPTY.to_owned(),
        settings: Value::Null,
        size,
        pipeline_ms: 0.0,
        table_bytes: 0,
        fetches: 0.0,
        samples: Samples::default(),
    };
    compile(gpu, &prepared, direction(scene.light[0], scene.light[1]), timed, clock)
}

/// The driver may put its work off until the first draw, so that is part of it.
fn compile(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    light: DVec3,
    timed: Timed,
    clock: &dyn Clock,
) -> Result<Built> {
    let begun = clock.wall();
    let pipeline = prepared.map_pipeline(gpu)?;
    let first = params(light, [FIRST_DRAW; 2]);
    pipeline.frames(FIRST_DRAW, FIRST_DRAW, bytemuck::bytes_of(&first), 1)?;
    let pipeline_ms = ms(clock.wall() - begun);
    let params = params(light, [timed.size as u32; 2]);
    Ok(Built { pipeline, params, timed: Timed { pipeline_ms, ..timed } })
}
