//! Measures groups of variants on one adapter.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{Optics, Variant};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::variant::{DISC, Function as _};
use glam::DVec3;
use serde_json::Value;

use super::clock::{Clock, ms};
use super::result::{Timed, settings};
use super::rounds::{self, Drawn, Executor, Rules, Samples, Timing};
use super::yardstick::{self, Yardstick};
use crate::drivers::gpu::{Gpu, Pipeline};
use crate::drivers::{Prepared, check, params};

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
        /// Diameter of the light, degrees. `None`: a single direction.
        disc_deg: Option<f64>,
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
        samples: Samples::default(),
    };
    match case {
        Case::Map { variant, height, frame, disc_deg } => {
            let height = height.as_deref().unwrap_or(scene.height);
            let placement = Placement { height, rotate_deg: scene.rotate_deg, variant };
            let mut prepared = Prepared::new(placement)?;
            if !scene.unchecked {
                check(&prepared, gpu)?;
            }
            if disc_deg.is_some() {
                under_disc(&mut prepared)?;
            }
            let cost = match disc_deg {
                None => prepared.form.cost(),
                Some(_) => DISC.cost(&prepared.form),
            };
            let timed = Timed {
                table_bytes: cost.table_bytes,
                fetches: cost.fetches_mean,
                ..timed(case.name(), settings(variant), *frame)
            };
            let radius_rad = 0.5 * disc_deg.unwrap_or(0.0).to_radians();
            compile(gpu, &prepared, (light, radius_rad), timed, clock)
        }
        Case::Yardstick { what, optics, frame } => {
            let variant = yardstick::variant(*what, optics);
            let prepared = yardstick::prepared(*what, scene.height, &variant)?;
            let timed = Timed {
                table_bytes: prepared.spectrum.byte_count() as u64,
                fetches: what.fetches(),
                ..timed(what.name().to_owned(), Value::Null, *frame)
            };
            compile(gpu, &prepared, (light, 0.0), timed, clock)
        }
    }
}

impl Case {
    /// Its name in records.
    pub fn name(&self) -> String {
        match self {
            Case::Map { variant, disc_deg: Some(deg), .. } => {
                format!("{} (disc {deg}°)", variant.name)
            }
            Case::Map { variant, .. } => variant.name.clone(),
            Case::Yardstick { what, .. } => what.name().to_owned(),
        }
    }
}

/// Makes the map that of a disc, whose radius is the fourth number of the block `Params`. A condition on a uniform in the shader
/// itself would not do: lavapipe compiles such a shader anew for every frame.
fn under_disc(prepared: &mut Prepared<'_>) -> Result<()> {
    let single = "diffraction(params.light.xyz, wr)";
    let disc = "diffraction_disc(params.light.xyz, params.light.w, wr)";
    let map = prepared.sources.0.entry("map".to_owned()).or_default();
    if !map.contains(single) {
        let cause = "the template of the map does not call the function of single directions";
        return Err(Error::new("bench", cause));
    }
    *map = map.replace(single, disc);
    Ok(())
}

/// Compiles and draws once: drivers may put off their work until the first draw.
fn compile(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    (light, radius_rad): (DVec3, f64),
    timed: Timed,
    clock: &dyn Clock,
) -> Result<Built> {
    let begun = clock.wall();
    let pipeline = prepared.map_pipeline(gpu)?;
    let lit = |pixels: [u32; 2]| {
        let mut params = params(light, pixels);
        params[3] = radius_rad as f32;
        params
    };
    let first = lit([FIRST_DRAW; 2]);
    pipeline.frames(FIRST_DRAW, FIRST_DRAW, bytemuck::bytes_of(&first), 1)?;
    let pipeline_ms = ms(clock.wall() - begun);
    let params = lit(timed.frame.map(|side| side as u32));
    Ok(Built { pipeline, params, timed: Timed { pipeline_ms, ..timed } })
}
