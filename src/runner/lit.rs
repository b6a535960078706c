//! A variant, or the exact reference, under the lights of a `lights.toml`.

use std::f64::consts::PI;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::field::reference::Directions;
use crate::light::{Light, Lights};
use crate::plan::{CoherenceScaling, Optics};
use crate::variant::{Arguments, Form};

use super::{Placement, Progress, Runner};

/// Remedy of optics that lights with a size cannot have.
const SCALING_REMEDY: &str =
    "set coherence_scaling = \"wavelength\", or source_diameter_deg, in [optics]";

/// Returns an error if lights with a size have no meaning under these optics.
pub fn check_scaling(optics: &Optics, lights: &Lights) -> Result<()> {
    match lights.with_size().next() {
        Some(light) if optics.coherence_scaling == CoherenceScaling::Fixed => {
            let cause = format!(
                "a light of kind \"{}\" has a size, but a coherence length of {} µm at all wavelengths is no light of a fixed size: orders would carry energy in proportion to (λ/550 nm)²",
                light.kind(),
                optics.coherence_um
            );
            Err(Error::new("coherence_scaling = \"fixed\"", cause).remedy(SCALING_REMEDY))
        }
        _ => Ok(()),
    }
}

/// Tristimulus values of the radiance towards viewers, relative to a white of radiance 1. `scale` is the radiance
/// relative to a white diffuser per unit of the runner's result under one direction.
///
/// A light of one direction counts by `(s/π) E ρ`. `progress` counts viewers, once for each light.
pub fn radiance_with(
    runner: &dyn Runner,
    scale: f64,
    lights: &Lights,
    views: &[DVec3],
    progress: Progress<'_>,
) -> Result<Vec<[f64; 3]>> {
    let mut sum = vec![[0.0; 3]; views.len()];
    let mut add = |colours: Vec<[f64; 3]>, factor: f64| {
        for (sum, colour) in sum.iter_mut().zip(colours) {
            *sum = std::array::from_fn(|c| sum[c] + factor * colour[c]);
        }
    };
    for (wi, irradiance, colour) in lights.directions() {
        let directions: Vec<Directions> = views.iter().map(|&wr| Directions { wi, wr }).collect();
        let colours = match colour == DVec3::ONE {
            true => runner.tristimulus_with(&directions, progress)?,
            false => runner.tinted(&directions, colour, progress)?,
        };
        add(colours, scale / PI * irradiance);
    }
    for light in lights.with_size() {
        add(runner.under(light, views, progress)?, 1.0);
    }
    Ok(sum)
}

/// Why a form has no function for a light with a size. `None` if it has. `name`: name of the variant.
pub fn missing(name: &str, form: &Form, light: &Light) -> Option<Error> {
    let known = form.functions();
    let calls = Arguments::under(light, DVec3::Z);
    let has = |(call, _): &(Arguments, f64)| known.iter().any(|f| f.kind() == call.kind());
    if !calls.is_empty() && calls.iter().all(has) {
        return None;
    }
    let cause = format!("has no function for a light of kind {:?}", light.kind());
    let remedy = match light.white().0 {
        Light::Disc { .. } => {
            "use a variant with mode = \"orders\", or for white discs mode = \"baked\" with spread_levels, and this kind in its lights, or --runner exact"
        }
        Light::Polygon { .. } => {
            "use a variant with mode = \"orders\" and this kind in its lights, or --runner exact"
        }
        Light::Sky { .. } | Light::Environment(_) => {
            "use a variant with mode = \"orders\", or mode = \"baked\" with spread_levels, and \"environment\" in its lights, or --runner exact"
        }
        _ => "use --runner exact",
    };
    Some(Error::new(name, cause).remedy(remedy))
}

/// Computes the results of calls.
pub type Calls<'a> = &'a dyn Fn(&[Arguments]) -> Result<Vec<[f64; 3]>>;

/// Radiance towards viewers under a light with a size, from calls of functions. `call`: results of calls. A polygon of more
/// than four corners takes several. It is an error if the form has no function for the light.
pub fn lit_by(
    name: &str,
    form: &Form,
    light: &Light,
    views: &[DVec3],
    call: Calls<'_>,
) -> Result<Vec<[f64; 3]>> {
    if let Some(error) = missing(name, form, light) {
        return Err(error);
    }
    let parts: Vec<Vec<(Arguments, f64)>> =
        views.iter().map(|wr| Arguments::under(light, *wr)).collect();
    let calls: Vec<Arguments> = parts.iter().flatten().map(|(call, _)| call.rounded()).collect();
    let results = call(&calls)?;
    let mut results = results.into_iter();
    let sum = |parts: &Vec<(Arguments, f64)>| {
        let each = parts.iter().zip(results.by_ref());
        let each = each.map(|((_, factor), xyz)| DVec3::from(xyz) * *factor);
        each.sum::<DVec3>().to_array()
    };
    Ok(parts.iter().map(sum).collect())
}

/// The `scale` of [`radiance_with`] for a variant; for the exact reference it is [`diffuser_scale`](crate::optics::diffuser_scale). It is an error if the unit of its result is arbitrary.
pub fn variant_scale(Placement { height, variant, .. }: Placement<'_>) -> Result<f64> {
    Form::new(variant, height)?.diffuser_scale(&variant.optics).ok_or_else(|| {
        Error::new(&variant.name, "the unit of its result is arbitrary, so it has no radiance")
            .remedy("choose another variant")
    })
}
