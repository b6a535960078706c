//! Measures groups of variants on one adapter.

use std::sync::Arc;

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::light::{Environment, Light, Studio};
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{Optics, Variant};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::tables::{Table, environment_table};
use diffraction_shaders::variant::{Cost, DISC, ENVIRONMENT, Function as _};
use glam::DVec3;
use serde_json::Value;

use super::clock::{Clock, ms};
use super::result::{Timed, settings};
use super::rounds::{self, Drawn, Executor, Rules, Samples, Timing};
use super::yardstick::{self, Yardstick};
use crate::drivers::gpu::{Gpu, Pipeline};
use crate::drivers::{Prepared, check, params, patterned};

/// Width and height in pixels of the first draw, which makes the driver compile.
const FIRST_DRAW: u32 = 8;

/// The surface and the light to draw.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The heights.
    pub height: &'a HeightField,
    /// Rotation of the surface about its normal, degrees.
    pub rotate_deg: f64,
    /// Direction towards the light: theta and phi in degrees.
    pub light: [f64; 2],
    /// Whether the driver's colours are not compared with the twin's before it is timed.
    pub unchecked: bool,
}

/// What lights a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Under {
    /// The scene's direction.
    Direction,
    /// A disc of this diameter about it, degrees.
    Disc(f64),
    /// A studio all around.
    Studio(Studio),
    /// The same, shown by an ordinary material in place of the variant, which lends it the surroundings.
    GgxIn(Studio),
}

/// A member of a group.
#[derive(Clone, Debug, PartialEq)]
pub enum Case {
    /// A variant's map.
    Map {
        /// The variant.
        variant: Box<Variant>,
        /// Heights in place of the scene's, if heights are varied.
        height: Option<Box<HeightField>>,
        /// Pixels along x and y.
        frame: [usize; 2],
        /// What lights it.
        under: Under,
    },
    /// A frame of another shader, for scale.
    Yardstick {
        /// Which shader.
        what: Yardstick,
        /// The optics, for the gain.
        optics: Box<Optics>,
        /// Pixels along x and y.
        frame: [usize; 2],
    },
}

/// The result of a group, in the order of its cases.
#[derive(Debug)]
pub struct Group {
    /// The clock that all times are from.
    pub timing: Timing,
    /// Maximum relative difference of the time stamps from the wall clock while warming up; `None` without time stamps.
    pub disagreement: Option<f64>,
    /// The times, or what went wrong.
    pub cases: Vec<Result<Timed>>,
}

/// Builds the pipelines of a group and draws them in turns, see [`rounds::measure`]. The first case is the baseline.
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
    // an error of building is reported before the error of drawing what was not built
    let timed = |(built, samples): (Result<Built>, Result<Samples>)| {
        let built = built?;
        Ok(Timed { samples: samples?, ..built.timed })
    };
    let cases = built.into_iter().zip(measured.samples).map(timed).collect();
    Group { timing: measured.timing, disagreement, cases }
}

/// A pipeline with its numbers.
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
                return Err(Error::new(error.subject(), "the pipeline was not built"));
            }
        };
        let [width, height] = built.timed.frame.map(|side| side as u32);
        let times =
            built.pipeline.frames(width, height, bytemuck::bytes_of(&built.params), frames)?;
        Ok(Drawn { wall: times.wall, stamps: times.stamps })
    }
}

fn build(gpu: &Gpu, scene: &Scene<'_>, case: &Case, clock: &dyn Clock) -> Result<Built> {
    let light = direction(scene.light[0], scene.light[1]);
    let timed = |variant: String, settings, frame| Timed {
        variant,
        settings,
        frame,
        pipeline_ms: 0.0,
        table_bytes: 0,
        fetches: 0.0,
        lookups: None,
        samples: Samples::default(),
    };
    match case {
        Case::Map { variant, height, frame, under } => {
            let height = height.as_deref().unwrap_or(scene.height);
            let placement = Placement { height, rotate_deg: scene.rotate_deg, variant };
            let mut prepared = Prepared::new(placement)?;
            if !scene.unchecked {
                check(&prepared, gpu)?;
            }
            let cost = match under {
                Under::Direction => prepared.form.cost(),
                Under::Disc(_) => DISC.cost(&prepared.form),
                Under::Studio(_) => ENVIRONMENT.cost(&prepared.form),
                // the texel of its colour
                Under::GgxIn(_) => {
                    Cost { evaluations_mean: 1.0, fetches_mean: 1.0, ..Cost::default() }
                }
            };
            let (mut lookups, mut around, mut radius_rad) = (None, None, 0.0);
            match under {
                Under::Direction => {}
                Under::Disc(deg) => {
                    call_in_map(
                        &mut prepared,
                        "diffraction_disc(params.light.xyz, params.light.w, wr)",
                    )?;
                    radius_rad = 0.5 * deg.to_radians();
                }
                Under::Studio(studio) | Under::GgxIn(studio) => {
                    let call = match under {
                        Under::GgxIn(_) => yardstick::ggx_in_surroundings(&mut prepared),
                        _ => "diffraction_environment(wr)",
                    };
                    call_in_map(&mut prepared, call)?;
                    let panorama = Arc::new(studio.panorama(Studio::WIDTH));
                    let map = Environment { panorama, scale: 1.0, rotate_deg: 0.0 };
                    // studios are dim enough to need no factor
                    around =
                        Light::Environment(map).filtered().map(|map| environment_table(&map).0);
                    lookups = Some(cost.evaluations_mean);
                }
            }
            let is_variant = !matches!(under, Under::GgxIn(_));
            let timed = Timed {
                table_bytes: cost.table_bytes,
                fetches: cost.fetches_mean,
                lookups,
                ..timed(
                    case.name(),
                    if is_variant { settings(variant) } else { Value::Null },
                    *frame,
                )
            };
            compile(gpu, (&prepared, around.as_ref()), (light, radius_rad), timed, clock)
        }
        Case::Yardstick { what, optics, frame } => {
            let variant = yardstick::variant(*what, optics);
            let prepared = yardstick::prepared(*what, scene.height, &variant)?;
            let timed = Timed {
                table_bytes: prepared.spectrum.byte_count() as u64,
                fetches: what.fetches(),
                ..timed(what.name().to_owned(), Value::Null, *frame)
            };
            compile(gpu, (&prepared, None), (light, 0.0), timed, clock)
        }
    }
}

impl Case {
    /// Its name in records.
    pub fn name(&self) -> String {
        match self {
            Case::Map { variant, under, .. } => match under {
                Under::Direction => variant.name.clone(),
                Under::Disc(deg) => format!("{} (disc {deg}°)", variant.name),
                Under::Studio(studio) => format!("{} ({})", variant.name, word(*studio)),
                Under::GgxIn(studio) => format!("{} ({})", Yardstick::Ggx.name(), word(*studio)),
            },
            Case::Yardstick { what, .. } => what.name().to_owned(),
        }
    }
}

fn word(studio: Studio) -> &'static str {
    Studio::WORDS.iter().find(|(_, of)| *of == studio).map_or("", |(word, _)| word)
}

/// Makes the map that of another function. The radius of a disc is the fourth number of the block `Params`. A condition on a uniform
/// in the shader itself would not do: lavapipe compiles such a shader anew for every frame.
fn call_in_map(prepared: &mut Prepared<'_>, call: &str) -> Result<()> {
    let single = "diffraction(params.light.xyz, wr)";
    let map = prepared.sources.0.entry("map".to_owned()).or_default();
    if !map.contains(single) {
        let cause = "the template of the map does not call the function of single directions";
        return Err(Error::new("bench", cause));
    }
    *map = map.replace(single, call);
    Ok(())
}

/// Compiles and draws once: drivers may put off their work until the first draw.
fn compile(
    gpu: &Gpu,
    (prepared, around): (&Prepared<'_>, Option<&Table>),
    (light, radius_rad): (DVec3, f64),
    timed: Timed,
    clock: &dyn Clock,
) -> Result<Built> {
    let begun = clock.wall();
    let pipeline = prepared.map_pipeline_in(gpu, around)?;
    let lit = |pixels: [u32; 2]| {
        let mut params = patterned(params(light, pixels), prepared);
        params[3] = radius_rad as f32;
        params
    };
    let first = lit([FIRST_DRAW; 2]);
    pipeline.frames(FIRST_DRAW, FIRST_DRAW, bytemuck::bytes_of(&first), 1)?;
    let pipeline_ms = ms(clock.wall() - begun);
    let params = lit(timed.frame.map(|side| side as u32));
    Ok(Built { pipeline, params, timed: Timed { pipeline_ms, ..timed } })
}
