//! The lights of the pictures: those of a file, or one for each `--light`.

use std::f64::consts::PI;
use std::path::Path;

use anyhow::Result;
use diffraction_cli::console::{Console, Errors};
use diffraction_shaders::input;
use diffraction_shaders::light::{Cap, LampSearch, Light, Lights};
use diffraction_shaders::plan::Variant;
use diffraction_shaders::runner::check_scaling;
use diffraction_shaders::variant::{Form, FunctionKind};
use glam::DVec3;

use super::args::Args;
use crate::scene::drawing::{Look, check_counts};
use crate::scene::lights::{facing, in_world, refused};

/// Exposure of a picture in which a white diffuser that faces the lights has the radiance 1.
const EXPOSURE: f64 = 0.5;

/// Where the lights come from.
pub(super) enum Lamps {
    /// A file: its name, its lights in the world, and the radiance of a white diffuser that faces all of them.
    File(String, Vec<Light>, f64),
    /// Options: directions, and the angular radius of the lights, 0 for single directions.
    Options(Vec<DVec3>, f64),
}

impl Lamps {
    pub(super) fn read(args: &Args, console: &Console) -> Result<Lamps> {
        match &args.lights {
            Some(path) => Lamps::of_file(path, console),
            None => {
                let directions = args.light.iter().map(|light| DVec3::from(light.0)).collect();
                Ok(Lamps::Options(directions, 0.5 * args.light_diameter_deg.to_radians()))
            }
        }
    }

    /// Lamps of maps are discs here, unless the file says otherwise: the functions of discs draw them with their edge.
    fn of_file(path: &Path, console: &Console) -> Result<Lamps> {
        let read = input::read_lights_with(path, LampSearch::Auto);
        let Lights { all, notes } = read.map_err(Errors)?;
        notes.iter().for_each(|note| console.note(note));
        let lights: Vec<Light> = all.iter().map(in_world).collect::<Result<_, _>>()?;
        let white: f64 = lights.iter().map(facing).sum();
        Ok(Lamps::File(path.display().to_string(), lights, if white > 0.0 { white } else { 1.0 }))
    }

    /// The lights on a variant with or without a function for discs. `directions` stand for those of the options.
    pub(super) fn on(&self, has_disc: bool, directions: Option<&[DVec3]>) -> Vec<Light> {
        match self {
            Lamps::File(_, lights, _) => lights.clone(),
            Lamps::Options(given, radius_rad) => {
                let radius_rad = if has_disc { *radius_rad } else { 0.0 };
                let directions = directions.unwrap_or(given);
                directions.iter().map(|direction| from(*direction, radius_rad)).collect()
            }
        }
    }

    /// Refuses lights that a scene cannot show on a variant.
    pub(super) fn check(&self, variant: &Variant, form: &Form, args: &Args) -> Result<()> {
        let lights = self.on(has_disc(form), None);
        let subject = match self {
            Lamps::File(name, ..) => name.as_str(),
            Lamps::Options(..) => "--light",
        };
        check_counts(subject, &lights)?;
        if args.no_diffraction {
            return Ok(());
        }
        for (i, light) in lights.iter().enumerate() {
            // a map with lamps is several lights
            let is_counted = !lights.iter().any(|light| light.kind() == "environment");
            let subject = match is_counted {
                true => format!("{subject}: light {}", i + 1),
                false => subject.to_owned(),
            };
            if let Some(error) = refused(&subject, &variant.name, form, light) {
                return Err(error.into());
            }
        }
        check_scaling(&variant.optics, &Lights { all: lights, notes: Vec::new() })?;
        Ok(())
    }

    /// Whether the options ask for discs.
    pub(super) fn wants_discs(&self) -> bool {
        matches!(self, Lamps::Options(_, radius_rad) if *radius_rad > 0.0)
    }

    /// Whether these are single directions from options.
    pub(super) fn are_plain(&self, has_disc: bool) -> bool {
        matches!(self, Lamps::Options(_, radius_rad) if *radius_rad == 0.0 || !has_disc)
    }

    /// Radiance of a white diffuser that faces the lights: each light of the options shows it as 1.
    fn white(&self) -> f64 {
        match self {
            Lamps::File(.., white) => *white,
            Lamps::Options(..) => 1.0,
        }
    }

    /// The exposure unless the options say otherwise.
    pub(super) fn exposure(&self) -> f64 {
        EXPOSURE / self.white()
    }

    pub(super) fn look(&self, lights: Vec<Light>, args: &Args) -> Look {
        let (texture_weight, diffracts) = (args.texture_weight, !args.no_diffraction);
        Look { lights, texture_weight, unlit: self.white(), diffracts }
    }
}

/// Whether a form has the function for discs.
pub(super) fn has_disc(form: &Form) -> bool {
    form.functions().iter().any(|function| function.kind() == FunctionKind::Disc)
}

/// A light under which a white diffuser that faces it has the radiance 1.
fn from(direction: DVec3, radius_rad: f64) -> Light {
    let axis = direction.normalize();
    if radius_rad > 0.0 {
        return Light::Disc { cap: Cap { axis, radius_rad }, irradiance: PI };
    }
    Light::Direction { direction: axis, irradiance: PI }
}
