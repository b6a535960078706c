//! What a shader offers to call, a file for each function. A form says which of them it has; text, manifest, probes and cost
//! follow.

mod directional;

use crate::error::Result;
use crate::field::reference::Directions;
use crate::plan::Optics;
use crate::surface::HeightField;

use super::{Cost, Form, Twin};

pub use directional::{DIRECTIONAL, Directional, PROBES};

/// A function of a shader, in every language by the same name.
pub trait Function: Sync {
    /// Its name.
    fn name(&self) -> &'static str;

    /// The function of the same arguments that returns tristimulus values.
    fn tristimulus_name(&self) -> &'static str;

    /// Arguments and result in WGSL, behind the name.
    fn signature(&self) -> &'static str;

    /// What the arguments are, in words.
    fn arguments(&self) -> &'static str;

    /// What a lit pixel costs that calls it once.
    fn cost(&self, form: &Form) -> Cost;

    /// Arguments at which an integration is tested, with their exact results.
    fn probes(
        &self,
        height: &HeightField,
        rotate_deg: f64,
        optics: &Optics,
    ) -> Result<Vec<ExactProbe>>;

    /// Its algorithm in f64: relative tristimulus values.
    fn evaluate(&self, twin: &Twin<'_>, arguments: Directions) -> [f64; 3];
}

/// Arguments of a probe and their exact result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactProbe {
    /// To the light and to the viewer, of components that 32-bit floats hold exactly.
    pub directions: Directions,
    /// Relative tristimulus values, gain included.
    pub xyz: [f64; 3],
}

/// All functions.
pub static FUNCTIONS: [&dyn Function; 1] = [&DIRECTIONAL];
