//! The algorithms of the templates in f64, function by function.
//!
//! `twin/x.rs` has the same function names as `templates/x.wgsl`. Parts that all forms share are not repeated: the f64
//! form of `gain.wgsl` is [`crate::optics`], and [`crate::optics::brdf_map`] is the f64 form of the map's geometry.
//! `full.wgsl` and `thesis.wgsl` compute the same sum in different orders; `twin/full.rs` is the twin of both.

mod adaptive;
pub(super) mod arrivals;
mod baked;
mod bins;
mod cells;
mod colour_path;
mod disc;
mod efficiencies;
pub(super) mod environment;
mod full;
mod gems;
pub(super) mod lamps;
mod matter;
pub mod mesh;
mod nodes;
mod order_path;
mod pq;
mod prefiltered;
mod rectangle;
mod series;
mod warped;
mod window;

use glam::{DVec3, DVec4};

use crate::field::reference::Directions;
use crate::light::Surroundings;
use crate::tables::{
    COEFFICIENTS, PATHS, SPECTRUM, STREAKS, Settings, TERMS, Table, single_wavelength,
};

use super::{Arguments, Around, Form, FullPrefiltered, FullWindow, Pattern, Pq};

/// Everything that a pixel of a variant reads, and the variant's algorithm.
#[derive(Clone, Copy)]
pub struct Twin<'a> {
    /// How the variant computes.
    pub form: &'a Form,
    /// Table of terms, of colours or of efficiencies, rounded or not. Empty if the form has neither.
    pub terms: &'a Table,
    /// Spectrum table, rounded or not.
    pub spectrum: &'a Table,
    /// Table of coefficients, of moments or of colours with wider lobes, rounded or not. Empty if the form has neither.
    pub coefficients: &'a Table,
    /// Table of streaks, rounded or not. Empty if the form has none.
    pub streaks: &'a Table,
    /// Table of paths, rounded or not. Empty if the form has none.
    pub paths: &'a Table,
    /// Rotation of the surface, degrees.
    pub rotate_deg: f64,
    /// What calls mean by [`Around::Host`].
    pub surroundings: Option<&'a dyn Surroundings>,
}

impl<'a> Twin<'a> {
    /// Finds the tables by their bindings.
    pub fn new(form: &'a Form, tables: &'a [Table], rotate_deg: f64) -> Twin<'a> {
        let at = |binding| tables.iter().find(|t| t.binding == binding).unwrap_or(&ABSENT);
        Twin {
            form,
            terms: at(TERMS),
            spectrum: at(SPECTRUM),
            coefficients: at(COEFFICIENTS),
            streaks: at(STREAKS),
            paths: at(PATHS),
            rotate_deg,
            surroundings: None,
        }
    }

    /// Relative tristimulus values of `ρ`.
    pub fn tristimulus(&self, directions: Directions) -> [f64; 3] {
        match self.form {
            Form::FullWindow(FullWindow { coat, .. })
            | Form::FullPrefiltered(FullPrefiltered { coat, .. })
            | Form::Pq(Pq { coat, .. }) => nodes::tristimulus(self, coat, directions),
            Form::Lobes(form) => {
                let bins = adaptive::Bins::Series(&form.series);
                adaptive::tristimulus(self, &form.sum, bins, directions)
            }
            Form::Warped(form) => warped::tristimulus(self, form, directions),
            Form::Baked(form) => baked::tristimulus(self, form, directions),
            Form::Gems(_) => gems::tristimulus(self, directions),
            Form::Orders(form) => {
                let bins = adaptive::Bins::Efficiencies(form);
                adaptive::tristimulus(self, &form.sum, bins, directions)
            }
        }
    }

    /// Result of a call for a texel of a pattern, see [`Twin::evaluate`].
    pub fn evaluate_on(&self, pattern: &Pattern, arguments: Arguments) -> Option<[f64; 3]> {
        if *pattern == Pattern::NONE {
            return self.evaluate(arguments);
        }
        let form = self.form.patterned(pattern);
        let rotate_deg = self.rotate_deg + pattern.angle_deg;
        Twin { form: &form, rotate_deg, ..*self }.evaluate(arguments)
    }

    /// Result of a call: tristimulus values in the unit of the function. `None` if the form does not have the function.
    pub fn evaluate(&self, arguments: Arguments) -> Option<[f64; 3]> {
        match (arguments, self.form) {
            (Arguments::Direction(directions), _) => Some(self.tristimulus(directions)),
            (Arguments::Spread { directions, spread }, Form::Baked(form))
                if form.wide.is_some() =>
            {
                Some(baked::tristimulus_spread(self, form, directions, spread))
            }
            (Arguments::Disc { axis, radius_rad, colour: None, wr }, Form::Baked(form))
                if form.wide.as_ref().is_some_and(|wide| wide.has_disc) =>
            {
                Some(baked::tristimulus_disc(self, form, axis, radius_rad, wr))
            }
            (Arguments::Disc { axis, radius_rad, colour, wr }, Form::Orders(form)) => {
                Some(match colour {
                    None => disc::tristimulus_disc(self, form, axis, radius_rad, wr),
                    Some(colour) => {
                        let disc = (axis, radius_rad);
                        disc::tristimulus_disc_coloured(self, form, disc, colour, wr)
                    }
                })
            }
            (Arguments::Rectangle { corners, colour, wr }, Form::Orders(form)) => {
                Some(match colour {
                    None => rectangle::tristimulus_rectangle(self, form, corners, wr),
                    Some(colour) => {
                        rectangle::tristimulus_rectangle_coloured(self, form, corners, colour, wr)
                    }
                })
            }
            (Arguments::Environment { around, wr }, form) => {
                let around: &dyn Surroundings = match &around {
                    Around::Sky(sky) => sky,
                    Around::Host => self.surroundings?,
                };
                match form {
                    Form::Orders(form) => {
                        Some(environment::tristimulus_environment(self, form, around, wr))
                    }
                    Form::Baked(form) if form.cells.is_some() => {
                        Some(cells::tristimulus_environment(self, form, around, wr))
                    }
                    _ => None,
                }
            }
            (Arguments::Path { sky, random, wr }, _) => {
                let path = self.path(wr, random)?;
                let radiance = sky.seen(path.truncate(), 0.0);
                let weight = DVec3::from(self.path_weight(wr, path)?);
                let light = self.path_light(radiance, path.w);
                Some((light.unwrap_or(radiance.element_sum() / 3.0) * weight).to_array())
            }
            _ => None,
        }
    }

    /// A path from three numbers, 0 to 1: the direction to the light, and the wavelength in µm, 0 for all. z of the direction is
    /// 0 where no light comes. `None` if the form has no paths.
    pub fn path(&self, wr: DVec3, random: DVec3) -> Option<DVec4> {
        match self.form {
            Form::Orders(form) => Some(order_path::diffraction_path(self, form, wr, random)),
            Form::Baked(_) => Some(colour_path::diffraction_path(self, wr, random)),
            _ => None,
        }
    }

    /// Tristimulus values of the weight of a path.
    pub fn path_weight(&self, wr: DVec3, path: DVec4) -> Option<[f64; 3]> {
        match self.form {
            Form::Orders(form) => {
                Some(order_path::tristimulus_weight(self, form, wr, path).to_array())
            }
            Form::Baked(form) => Some(colour_path::tristimulus_weight(self, form, wr, path)),
            _ => None,
        }
    }

    /// Light of a colour at a wavelength in µm, relative to white light. `None` if paths have no wavelengths.
    pub fn path_light(&self, rgb: DVec3, lambda_um: f64) -> Option<f64> {
        match self.form {
            Form::Orders(form) => Some(order_path::diffraction_light(self, form, rgb, lambda_um)),
            _ => None,
        }
    }

    /// `|P|²` of this variant at one wavelength in µm, along `path = (u, v, w)`. `None` if the variant does not have
    /// wavelengths.
    pub fn response(&self, path: DVec3, lambda_um: f64) -> Option<f64> {
        match self.form {
            Form::FullWindow(form) => Some(full::response(self, form, path, lambda_um)),
            Form::FullPrefiltered(form) => {
                Some(prefiltered::response(self, &form.series, &form.coat, path, lambda_um))
            }
            Form::Warped(form) => {
                Some(prefiltered::response(self, &form.series, &form.coat, path, lambda_um))
            }
            Form::Pq(form) => Some(pq::response(self, form, path, lambda_um)),
            // the segment shrinks to a point
            Form::Lobes(form) => {
                let matter = form.sum.coat.rows.clone();
                let settings = Settings { matter, ..form.series.settings(self.rotate_deg) };
                let spectrum = single_wavelength(1e3 * lambda_um, settings);
                let twin = Twin { spectrum: &spectrum, ..*self };
                let bins = adaptive::Bins::Series(&form.series);
                Some(adaptive::corridor(&twin, &form.sum, bins, path, None).x)
            }
            Form::Orders(form) => {
                let matter = form.sum.coat.rows.clone();
                let settings = Settings { matter, ..Settings::rotated(self.rotate_deg) };
                let spectrum = single_wavelength(1e3 * lambda_um, settings);
                let twin = Twin { spectrum: &spectrum, ..*self };
                let bins = adaptive::Bins::Efficiencies(form);
                Some(adaptive::corridor(&twin, &form.sum, bins, path, None).x)
            }
            Form::Gems(_) | Form::Baked(_) => None,
        }
    }

    /// Whether the spectrum is a single wavelength.
    fn is_monochromatic(&self) -> bool {
        self.spectrum.width == 1
    }
}

impl mesh::OrientationMap {
    /// A map with angle 0 everywhere, for meshes where only the vertices have angles.
    pub fn none() -> mesh::OrientationMap {
        mesh::OrientationMap { width: 1, height: 1, angles: vec![0.0], ratios: Vec::new() }
    }
}

static ABSENT: Table = Table::ABSENT;
