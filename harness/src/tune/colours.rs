//! Errors of candidates: their twins on rounded tables against the exact colours.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::field::comparison_directions::on_orders;
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::optics::brdf_map::view_directions;
use diffraction_shaders::optics::colour_difference::{
    auto_exposure, colour_difference, map_difference,
};
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{Optics, Variant};
use diffraction_shaders::runner::{Exact, Placement, Runner, TwinRunner, rounded};
use diffraction_shaders::surface::HeightField;
use glam::DVec3;

use crate::results::LightError;

use super::search::Found;

/// Width and height in pixels of the maps for colour differences.
pub const MAP: usize = 64;
/// Number of random directions on strong orders and around the mirror direction, for each light.
pub const DRAWN: usize = 2048;
/// Seed of the random directions, as in `compare`.
const SEED: u64 = 1;
/// A first look takes every `LOOK`-th direction of the first light.
const LOOK: usize = 8;
/// A candidate whose 95th percentile exceeds this many times the budget, at a first look or under one light, is not measured to
/// the end.
const FAR: f64 = 2.0;

/// The exact colours of a surface under several lights.
#[derive(Clone, Debug)]
pub struct Truth {
    lights: Vec<Lit>,
}

/// The exact colours under one light.
#[derive(Clone, Debug)]
struct Lit {
    light: [f64; 2],
    /// The pixels of the map, then the random directions.
    directions: Vec<Directions>,
    /// Number of directions that are pixels of the map.
    map: usize,
    colours: Vec<[f64; 3]>,
    exposure: f64,
    map_exposure: Option<f64>,
    brightest: f64,
}

impl Truth {
    /// Computes the exact colours. `lights` are theta and phi in degrees. `progress` gets the share of the finished work.
    pub fn new(
        height: &HeightField,
        rotate_deg: f64,
        optics: &Optics,
        lights: &[[f64; 2]],
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Truth> {
        // only the optics of the variant are used
        let variant = Variant::texts(optics);
        let exact = Exact(Placement { height, rotate_deg, variant: &variant });
        let lit = |light: &[f64; 2]| {
            let wi: DVec3 = rounded(direction(light[0], light[1]));
            let mut directions: Vec<Directions> =
                view_directions(MAP).into_iter().map(|wr| Directions { wi, wr }).collect();
            let map = directions.len();
            directions.extend(on_orders(height, optics, rotate_deg, wi, DRAWN, SEED));
            let colours = exact.tristimulus_with(&directions, progress)?;
            let exposure = auto_exposure(&colours).ok_or_else(|| {
                let subject = format!("light {},{}", light[0], light[1]);
                Error::new(subject, "the surface is black under it")
            })?;
            let map_exposure = auto_exposure(&colours[..map]);
            let brightest = colours.iter().map(|c| c[1]).fold(0.0, f64::max);
            let light = *light;
            Ok(Lit { light, directions, map, colours, exposure, map_exposure, brightest })
        };
        Ok(Truth { lights: lights.iter().map(lit).collect::<Result<_>>()? })
    }

    /// Number of directions that [`Truth::new`] computes for each light.
    pub fn directions() -> usize {
        view_directions(MAP).len() + DRAWN
    }

    /// Takes a first look under the first light. If that is not far over the budget, computes the errors under all lights.
    pub fn measure(&self, subject: Placement<'_>, budget_de: f64) -> Found {
        let measured = TwinRunner::new(subject, true).and_then(|twin| {
            let mut errors = Vec::new();
            if let Some(first) = self.lights.first() {
                let look = first.look(&subject.variant.name, &twin)?;
                if look > FAR * budget_de {
                    return Ok(Found::Far(look, first.light));
                }
            }
            for lit in &self.lights {
                let error = lit.error(&subject.variant.name, &twin)?;
                if error.worst_p95() > FAR * budget_de {
                    return Ok(Found::Far(error.worst_p95(), error.light));
                }
                errors.push(error);
            }
            Ok(Found::Errors(errors))
        });
        measured.unwrap_or_else(|error| Found::Failed(error.to_string()))
    }

    /// Computes the errors under all lights, however large.
    pub fn of(&self, subject: Placement<'_>) -> Result<Vec<LightError>> {
        let twin = TwinRunner::new(subject, true)?;
        self.lights.iter().map(|lit| lit.error(&subject.variant.name, &twin)).collect()
    }
}

impl Lit {
    fn look(&self, name: &str, twin: &TwinRunner<'_>) -> Result<f64> {
        let places = || (0..self.directions.len()).step_by(LOOK);
        let directions: Vec<Directions> = places().map(|i| self.directions[i]).collect();
        let expected: Vec<[f64; 3]> = places().map(|i| self.colours[i]).collect();
        let colours = twin.tristimulus(&directions)?;
        Ok(colour_difference(name, &expected, &colours, Some(self.exposure))?.de2000.p95)
    }

    fn error(&self, name: &str, twin: &TwinRunner<'_>) -> Result<LightError> {
        let colours = twin.tristimulus(&self.directions)?;
        let all = colour_difference(name, &self.colours, &colours, Some(self.exposure))?;
        let map = self.map_exposure.and_then(|exposure| {
            let [expected, colours] = [&self.colours, &colours].map(|c| &c[..self.map]);
            map_difference(name, expected, colours, self.brightest, exposure)
        });
        let map_p95 = map.map(|map| map.de2000.p95);
        let max = map.map_or(0.0, |map| map.de2000.max).max(all.de2000.max);
        Ok(LightError { light: self.light, p95: all.de2000.p95, max, map_p95 })
    }
}
