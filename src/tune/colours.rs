//! Errors of candidates: their twins, on tables rounded as a shader reads them, against the exact colours.

use glam::DVec3;

use crate::error::{Error, Result, Stage};
use crate::frame::view_directions;
use crate::height::HeightField;
use crate::measure::{auto_exposure, compare, compare_map, on_orders};
use crate::optics::direction;
use crate::plan::{Optics, Variant};
use crate::record::LightError;
use crate::reference::Directions;
use crate::runner::{Exact, Runner, Subject, TwinRunner, rounded};

use super::search::Found;

/// Pixels along a side of the maps that colours are compared on.
pub const MAP: usize = 64;
/// Directions that are drawn on strong orders and around the mirror direction, for each light.
pub const DRAWN: usize = 2048;
/// Seed of the drawn directions; the same as that of `compare`.
const SEED: u64 = 1;
/// One in so many directions of the first light is taken at a first look.
const LOOK: usize = 8;
/// A 95th percentile at a first look that is this many times the budget is not measured further.
const FAR: f64 = 2.0;

/// The exact colours of a surface under some lights.
#[derive(Clone, Debug)]
pub struct Truth {
    lights: Vec<Lit>,
}

/// Under one light.
#[derive(Clone, Debug)]
struct Lit {
    light: [f64; 2],
    /// The pixels of the map, then drawn ones.
    directions: Vec<Directions>,
    /// How many are the map's.
    map: usize,
    colours: Vec<[f64; 3]>,
    exposure: f64,
    map_exposure: Option<f64>,
    brightest: f64,
}

impl Truth {
    /// Computes the exact colours; `lights` are theta and phi in degrees. Tells the share of the work that is done.
    pub fn new(
        height: &HeightField,
        rotate_deg: f64,
        optics: &Optics,
        lights: &[[f64; 2]],
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Truth> {
        // of the variant only the optics count
        let variant = Variant::texts(optics);
        let exact = Exact(Subject { height, rotate_deg, variant: &variant });
        let lit = |light: &[f64; 2]| {
            let wi: DVec3 = rounded(direction(light[0], light[1]));
            let mut directions: Vec<Directions> =
                view_directions(MAP).into_iter().map(|wr| Directions { wi, wr }).collect();
            let map = directions.len();
            directions.extend(on_orders(height, optics, rotate_deg, wi, DRAWN, SEED));
            let colours = exact.tristimulus(&directions, progress)?;
            let exposure = auto_exposure(&colours).ok_or_else(|| {
                let subject = format!("light {},{}", light[0], light[1]);
                Error::new(Stage::Run, subject, "the surface is black under it")
            })?;
            let map_exposure = auto_exposure(&colours[..map]);
            let brightest = colours.iter().map(|c| c[1]).fold(0.0, f64::max);
            let light = *light;
            Ok(Lit { light, directions, map, colours, exposure, map_exposure, brightest })
        };
        Ok(Truth { lights: lights.iter().map(lit).collect::<Result<_>>()? })
    }

    /// Directions that [`Truth::new`] computes for each light.
    pub fn directions() -> usize {
        view_directions(MAP).len() + DRAWN
    }

    /// A first look under the first light, and errors under all of them where that is not far over the budget.
    pub fn measure(&self, subject: Subject<'_>, budget_de: f64) -> Found {
        let measured = TwinRunner::new(subject, true).and_then(|twin| {
            let look = self.look(subject, &twin)?;
            match look > FAR * budget_de {
                true => Ok(Found::Far(look)),
                false => self.errors(subject, &twin).map(Found::Errors),
            }
        });
        measured.unwrap_or_else(|error| Found::Failed(error.to_string()))
    }

    /// The errors under all lights.
    pub fn of(&self, subject: Subject<'_>) -> Result<Vec<LightError>> {
        self.errors(subject, &TwinRunner::new(subject, true)?)
    }

    fn look(&self, subject: Subject<'_>, twin: &TwinRunner<'_>) -> Result<f64> {
        let Some(lit) = self.lights.first() else { return Ok(0.0) };
        let places = || (0..lit.directions.len()).step_by(LOOK);
        let directions: Vec<Directions> = places().map(|i| lit.directions[i]).collect();
        let expected: Vec<[f64; 3]> = places().map(|i| lit.colours[i]).collect();
        let colours = twin.tristimulus(&directions, &|_| ())?;
        let name = &subject.variant.name;
        Ok(compare(name, &expected, &colours, Some(lit.exposure))?.de2000.p95)
    }

    fn errors(&self, subject: Subject<'_>, twin: &TwinRunner<'_>) -> Result<Vec<LightError>> {
        let name = &subject.variant.name;
        let one = |lit: &Lit| {
            let colours = twin.tristimulus(&lit.directions, &|_| ())?;
            let all = compare(name, &lit.colours, &colours, Some(lit.exposure))?;
            let map = lit.map_exposure.and_then(|exposure| {
                let [expected, colours] = [&lit.colours, &colours].map(|c| &c[..lit.map]);
                compare_map(name, expected, colours, lit.brightest, exposure)
            });
            let map_p95 = map.map(|map| map.de2000.p95);
            let max = map.map_or(0.0, |map| map.de2000.max).max(all.de2000.max);
            Ok(LightError { light: lit.light, p95: all.de2000.p95, max, map_p95 })
        };
        self.lights.iter().map(one).collect()
    }
}
