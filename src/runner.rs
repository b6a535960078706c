//! Ways to evaluate a variant: exactly, or by its twin in f64. The harness adds runners that run its shader on drivers.

mod cpu;
mod lit;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::field::reference::Directions;
use crate::light::Light;
use crate::optics::brdf_map::{BrdfMap, view_directions};
use crate::plan::Variant;
use crate::surface::HeightField;
use crate::variant::Form;

pub use cpu::{Exact, TwinRunner};
pub use lit::{check_scaling, lit_by, missing, radiance_with, variant_scale};

/// What is evaluated: a variant on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Placement<'a> {
    /// The heights.
    pub height: &'a HeightField,
    /// Rotation of the surface about its normal, degrees.
    pub rotate_deg: f64,
    /// The variant.
    pub variant: &'a Variant,
}

/// Called with the number of directions finished since the last call, from any thread.
pub type Progress<'a> = &'a (dyn Fn(usize) + Sync);

/// Why single directions have no colour in shaders.
pub const NO_SPECTRUM: &str = "the function of a single direction reads tables of white light, so that there is no spectrum left that a colour could weight";

/// One way to evaluate a variant.
pub trait Runner {
    /// Its route: `exact`, `twin`, `vulkan:ADAPTER`, `gl:ADAPTER`, `spirv:ADAPTER`, `hlsl:ADAPTER`, `glsl450`,
    /// `glsl-es300`, `webgpu`, `webgl2`.
    fn route(&self) -> String;

    /// Relative tristimulus values, gain included.
    fn tristimulus(&self, directions: &[Directions]) -> Result<Vec<[f64; 3]>> {
        self.tristimulus_with(directions, &|_| ())
    }

    /// [`Runner::tristimulus`] with progress.
    fn tristimulus_with(
        &self,
        directions: &[Directions],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>>;

    /// [`Runner::tristimulus_with`] for light of a colour, linear sRGB. It is an error if the variant has no such light.
    fn tinted(&self, _: &[Directions], _: DVec3, _: Progress<'_>) -> Result<Vec<[f64; 3]>> {
        let cause = format!("cannot have coloured light of one direction: {NO_SPECTRUM}");
        let remedy = "make it a disc of the source's width, with mode = \"orders\"; or use --runner exact, or remove the colour";
        Err(Error::new(self.route(), cause).remedy(remedy))
    }

    /// `|P|²` at one wavelength in nm, without the gain. It is an error if the variant does not have wavelengths.
    fn response(&self, directions: &[Directions], lambda_nm: f64) -> Result<Vec<f64>>;

    /// Tristimulus values of the radiance towards viewers under one light with a size, relative to a white of radiance
    /// 1. It is an error if the variant has no function for such a light.
    fn under(
        &self,
        light: &Light,
        views: &[DVec3],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>>;

    /// A BRDF map, drawn by an entry point of its own if there is one.
    fn brdf_map(&self, light: DVec3, size: usize) -> Result<BrdfMap> {
        self.brdf_map_with(light, size, &|_| ())
    }

    /// [`Runner::brdf_map`] with progress.
    fn brdf_map_with(&self, light: DVec3, size: usize, progress: Progress<'_>) -> Result<BrdfMap> {
        let directions: Vec<Directions> =
            view_directions(size).into_iter().map(|wr| Directions { wi: light, wr }).collect();
        Ok(BrdfMap::from_disc(size, &self.tristimulus_with(&directions, progress)?))
    }
}

/// Returns an error if the form cannot compute a response at one wavelength. `name`: name of the variant.
pub fn has_wavelengths(name: &str, form: &Form) -> Result<()> {
    match form.no_wavelength_axis() {
        None => Ok(()),
        Some(cause) => Err(Error::new(name, cause).remedy("compute its colours instead")),
    }
}

/// The nearest vector of 32-bit floats, as a shader receives it.
pub fn rounded(v: DVec3) -> DVec3 {
    v.as_vec3().as_dvec3()
}
