//! Compares every variant, by every route, with the exact reference, its twin and the other routes.
//!
//! Each error is split into parts: the variant's approximation (*model*: unrounded twin against the exact field), the
//! rounding of the tables (*packing*: twin against unrounded twin), and a driver's 32-bit arithmetic (*arithmetic*: route
//! against twin). Directions, exposure and lit directions are as in [`measure`](diffraction_shaders::optics::colour_difference).
//!
//! Results go to a [`Sink`] as soon as they are known. A route that fails three times in a row is dropped.

mod controls;
mod pictures;
mod unit;

use std::collections::{BTreeMap, BTreeSet};

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::field::orders::OrderSum;
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::input;
use diffraction_shaders::light::Lights;
use diffraction_shaders::optics::Matter;
use diffraction_shaders::optics::brdf_map::BrdfMap;
use diffraction_shaders::plan::{Mode, Optics, SurfaceSpec, Variant};
use diffraction_shaders::runner::{Placement, Runner, check_scaling, missing, radiance_with};
use diffraction_shaders::surface::{self, HeightField};
use diffraction_shaders::survey::memory::{self, Memory};
use diffraction_shaders::variant::Form;
use glam::DVec3;

use crate::drivers::Prepared;
use crate::drivers::routes::Route;
use crate::results::{Energy, Gap, Lit, Record};

pub use controls::{
    AROUND_CONTROLS, CONTROLS, LAMP_CONTROLS, MATTER_CONTROLS, SPREAD_CONTROLS,
    SURFACE as CONTROL_SURFACE,
};
pub use pictures::{AMPLIFIED, difference, mean_flip};

/// Failures in a row after which a route is dropped.
const PATIENCE: u32 = 3;

/// A comparison to run.
pub struct Job<'a> {
    /// The surfaces, in order.
    pub surfaces: &'a [SurfaceSpec],
    /// The variants, each on every surface that it is for.
    pub variants: &'a [Variant],
    /// The open routes. The twin is always compared in addition.
    pub routes: &'a [Box<dyn Route>],
    /// What shines, one after the other.
    pub lights: &'a [Shine<'a>],
    /// Width and height of the maps, in pixels.
    pub size: usize,
    /// Factor on luminance before colour differences. `None`: computed from the exact map.
    pub exposure: Option<f64>,
    /// Number of variants per surface that slow routes take: of each mode the cheapest first.
    pub subset: usize,
    /// Bytes of memory that may be taken. More is an error before anything of the surface is computed.
    pub memory: u64,
}

/// What shines on a surface.
#[derive(Clone, Copy, Debug)]
pub enum Shine<'a> {
    /// A single direction: theta and phi in degrees.
    Direction([f64; 2]),
    /// Lights with their name.
    Lights(&'a str, &'a Lights),
}

impl Shine<'_> {
    /// As in records.
    pub fn lit(&self) -> Lit {
        match self {
            Shine::Direction(angles) => Lit::Direction(*angles),
            Shine::Lights(name, _) => Lit::Lights((*name).to_owned()),
        }
    }

    /// As a part of a file's name.
    fn place(&self) -> String {
        match self {
            Shine::Direction([theta, phi]) => format!("{theta}-{phi}"),
            Shine::Lights(name, _) => unit::safe(name),
        }
    }

    /// In messages.
    fn shown(&self) -> String {
        match self {
            Shine::Direction([theta, _]) => format!("light {theta}°"),
            Shine::Lights(name, _) => (*name).to_owned(),
        }
    }

    /// Why a variant has no colours under it.
    fn missing(&self, name: &str, form: &Form, optics: &Optics) -> Option<Error> {
        let Shine::Lights(_, lights) = self else { return None };
        if form.diffuser_scale(optics).is_none() {
            let cause = "the unit of its result is arbitrary, so it has no radiance";
            return Some(Error::new(name, cause));
        }
        if let Err(error) = check_scaling(optics, lights) {
            return Some(error);
        }
        lights.with_size().find_map(|light| missing(name, form, light))
    }
}

/// Takes results.
pub trait Sink {
    /// Takes a result.
    fn record(&mut self, record: Record) -> Result<()>;

    /// Takes a picture as PNG, by its path under the output folder.
    fn picture(&mut self, place: &str, png: Vec<u8>) -> Result<()>;

    /// Reports that work on something begins. Steps follow.
    fn begin(&mut self, what: &str);

    /// Reports that one of the [`steps`] is done.
    fn step(&mut self);

    /// Whether an earlier run has the results of this variant, with this configuration, for all of these routes.
    fn has(&self, unit: &Unit<'_>, routes: &[String]) -> bool;

    /// Whether an earlier run has this control of a route.
    fn has_control(&self, route: &str, control: &str) -> bool;
}

/// A variant on a surface under a light.
#[derive(Clone, Copy, Debug)]
pub struct Unit<'a> {
    /// The surface's name.
    pub surface: &'a str,
    /// The variant.
    pub variant: &'a Variant,
    /// What shines on it.
    pub light: Shine<'a>,
    /// Width and height of the map, in pixels.
    pub size: usize,
}

/// Number of steps of a whole run: one for each unit by each route and the twin, one for each route's controls.
pub fn steps(request: &Job<'_>) -> usize {
    let units = request.surfaces.len() * request.variants.len() * request.lights.len();
    units * (1 + request.routes.len()) + request.routes.len()
}

/// Whether this route is so slow that it takes only a subset of the variants.
pub fn is_slow(route: &str) -> bool {
    ["swiftshader", "webgpu", "webgl2"].iter().any(|name| route.to_lowercase().contains(name))
}

/// Runs the comparison.
pub fn run(request: &Job<'_>, sink: &mut dyn Sink) -> Result<()> {
    let mut failures = vec![0; request.routes.len()];
    for (route, failures) in request.routes.iter().zip(&mut failures) {
        sink.begin(&format!("controls by {}", route.name()));
        let with_lamps = request.lights.iter().any(|light| matches!(light, Shine::Lights(..)));
        let placed = request.variants.iter().flat_map(|variant| {
            request.surfaces.iter().filter_map(|surface| variant.on(surface)?.ok())
        });
        let with_matter = placed.into_iter().any(|variant| !variant.optics.is_plain());
        let has_around = |light: &Shine<'_>| match light {
            Shine::Lights(_, lights) => lights.all.iter().any(|light| light.is_all_round()),
            _ => false,
        };
        let with_around = request.lights.iter().any(has_around);
        let with = [with_lamps, with_matter, with_around];
        *failures = controls::run(route.as_ref(), with, sink)?;
        sink.step();
    }
    for spec in request.surfaces {
        let surface = input::load_surface(spec)?;
        run_surface(request, spec, &surface.field, &mut failures, sink)?;
    }
    Ok(())
}

/// What is asked: colours under one direction, or radiances under lights. The pixels of the map come first, then the random
/// directions.
enum Query {
    Direction { light: DVec3, directions: Vec<Directions> },
    Lights { lights: Lights, views: Vec<DVec3> },
}

/// The exact colours on a surface under a light.
struct Truth {
    query: Query,
    /// Number of directions that are pixels of the map.
    map: usize,
    colours: Vec<[f64; 3]>,
    exposure: f64,
    /// Exposure of the map alone, with which it is drawn; `None` if it is black.
    map_exposure: Option<f64>,
    /// Path of the map's picture.
    picture: String,
}

impl Truth {
    /// The colours by a runner, in the order of the directions. Under one direction the map is drawn by its own entry point.
    /// `scale`: radiance relative to a white diffuser per unit of a colour.
    fn ask(&self, runner: &dyn Runner, scale: f64, size: usize) -> Result<Vec<[f64; 3]>> {
        match &self.query {
            Query::Direction { light, directions } => {
                let mut colours = runner.brdf_map(*light, size)?.disc();
                colours.extend(runner.tristimulus(&directions[self.map..])?);
                Ok(colours)
            }
            Query::Lights { lights, views } => radiance_with(runner, scale, lights, views, &|_| ()),
        }
    }

    fn frame(&self, colours: &[[f64; 3]], size: usize) -> BrdfMap {
        BrdfMap::from_disc(size, &colours[..self.map])
    }
}

fn run_surface(
    request: &Job<'_>,
    spec: &SurfaceSpec,
    height: &HeightField,
    failures: &mut [u32],
    sink: &mut dyn Sink,
) -> Result<()> {
    let subset = subset(request, spec, height);
    // by optics and light, which variants share
    let mut truths: BTreeMap<(String, usize), Truth> = BTreeMap::new();
    let placed: Vec<Option<Result<Variant>>> =
        request.variants.iter().map(|variant| variant.on(spec)).collect();
    let around = memory::around_bytes(height.byte_count(), placed.len());
    for variant in placed.iter().flatten().flatten() {
        // a variant without a form is a gap, below
        let Ok(form) = Form::new(variant, height) else { continue };
        let memory = Memory::new(height, variant, &form, rayon::current_num_threads());
        let subject = format!("surface {}: variant {}", spec.name, variant.name);
        memory::within_budget(&subject, around + memory.to_compare(), request.memory)?;
    }
    for (index, (variant, here)) in request.variants.iter().zip(&placed).enumerate() {
        let skip = |sink: &mut dyn Sink| {
            (0..request.lights.len() * (1 + request.routes.len())).for_each(|_| sink.step());
        };
        let prepared = match here {
            None => {
                skip(sink);
                continue;
            }
            Some(Err(error)) => Err(error.to_string()),
            Some(Ok(variant)) => {
                let subject = Placement { height, rotate_deg: spec.rotate_deg, variant };
                let min_nm = variant.wavelengths.min_nm.min(380.0);
                let pitch = height.check_pitch(&surface::subject(spec), min_nm);
                let prepared = pitch.and_then(|()| Prepared::new(subject));
                prepared.map(|prepared| (subject, prepared)).map_err(|error| error.to_string())
            }
        };
        let (subject, prepared) = match prepared {
            Ok(prepared) => prepared,
            Err(reason) => {
                sink.record(gap("all", Some((&spec.name, &variant.name)), &reason, false))?;
                skip(sink);
                continue;
            }
        };
        let variant = subject.variant;
        let takes = |route: &dyn Route| subset.contains(&index) || !is_slow(&route.name());
        for route in request.routes.iter().filter(|route| !takes(route.as_ref())) {
            let reason = format!("not one of the {} variants that slow routes take", subset.len());
            sink.record(gap(&route.name(), Some((&spec.name, &variant.name)), &reason, false))?;
        }
        for (light_index, light) in request.lights.iter().enumerate() {
            let unit = Unit { surface: &spec.name, variant, light: *light, size: request.size };
            if let Some(reason) = light.missing(&variant.name, &prepared.form, &variant.optics) {
                let at = Some((spec.name.as_str(), variant.name.as_str()));
                sink.record(gap("all", at, &reason.to_string(), false))?;
                (0..=request.routes.len()).for_each(|_| sink.step());
                continue;
            }
            let names: Vec<String> = request
                .routes
                .iter()
                .filter(|route| takes(route.as_ref()))
                .map(|route| route.name())
                .collect();
            if sink.has(&unit, &names) {
                (0..=request.routes.len()).for_each(|_| sink.step());
                continue;
            }
            let key = (serde_json::to_string(&variant.optics).unwrap_or_default(), light_index);
            if !truths.contains_key(&key) {
                sink.begin(&format!("{}: exact, {}", spec.name, light.shown()));
                // the number stays the same in a resumed run
                let same = |other: &Option<Result<Variant>>| matches!(other, Some(Ok(other)) if other.optics == variant.optics);
                let number = placed.iter().position(same).unwrap_or(index);
                if light_index == 0 && matches!(light, Shine::Lights(..)) {
                    record_energy(&spec.name, subject, sink)?;
                }
                let truth = unit::truth(request, &unit, subject, number, sink)?;
                truths.insert(key.clone(), truth);
            }
            let Some(truth) = truths.get(&key) else { continue };
            sink.begin(&format!("{}: {}, {}", spec.name, variant.name, light.shown()));
            let chosen: Vec<Option<&dyn Route>> = request
                .routes
                .iter()
                .zip(failures.iter())
                .map(|(route, failures)| {
                    (takes(route.as_ref()) && *failures < PATIENCE).then_some(route.as_ref())
                })
                .collect();
            unit::run(&unit, &prepared, truth, &chosen, failures, sink)?;
        }
    }
    Ok(())
}

/// Records what a surface returns of all light, if that is worth its time.
fn record_energy(surface: &str, subject: Placement<'_>, sink: &mut dyn Sink) -> Result<()> {
    let Placement { height, rotate_deg, variant } = subject;
    if !OrderSum::has_white_sky(height, &Matter::new(&variant.optics)?) {
        return Ok(());
    }
    sink.begin(&format!("{surface}: under a white sky"));
    let white_sky = OrderSum::new(height, rotate_deg, &variant.optics)?.white_sky();
    let mut optics = serde_json::to_value(&variant.optics).unwrap_or_default();
    if let (true, Some(keys)) = (variant.optics.is_plain(), optics.as_object_mut()) {
        // a dielectric in air is described by its index
        keys.retain(|key, _| !Optics::MATTER.contains(&key.as_str()));
    }
    sink.record(Record::Energy(Energy { surface: surface.to_owned(), optics, white_sky }))
}

/// The variants that slow routes take on a surface: the cheapest of each mode, then the second cheapest of each, and so on.
fn subset(request: &Job<'_>, spec: &SurfaceSpec, height: &HeightField) -> BTreeSet<usize> {
    let mut by_mode: BTreeMap<Mode, Vec<(u64, usize)>> = BTreeMap::new();
    for (index, variant) in request.variants.iter().enumerate() {
        let Some(Ok(variant)) = variant.on(spec) else { continue };
        if let Ok(form) = Form::new(&variant, height) {
            by_mode.entry(variant.mode).or_default().push((form.cost().fetches, index));
        }
    }
    let mut ranked: Vec<(usize, Mode, usize)> = Vec::new();
    for (mode, mut variants) in by_mode {
        variants.sort_unstable();
        ranked.extend(variants.iter().enumerate().map(|(rank, (_, index))| (rank, mode, *index)));
    }
    ranked.sort_unstable();
    ranked.into_iter().take(request.subset).map(|(_, _, index)| index).collect()
}

fn failed(route: &str, at: Option<(&str, &str)>, reason: &str) -> Record {
    gap(route, at, reason, true)
}

fn gap(route: &str, at: Option<(&str, &str)>, reason: &str, failed: bool) -> Record {
    Record::Gap(Gap {
        route: route.to_owned(),
        surface: at.map(|(surface, _)| surface.to_owned()),
        variant: at.map(|(_, variant)| variant.to_owned()),
        reason: reason.to_owned(),
        failed,
    })
}
