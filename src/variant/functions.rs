//! The functions that engines can call in a shader, one file for each. A form lists its functions; text, manifest,
//! probes and cost follow from that.

mod directional;

use crate::error::Result;
use crate::field::reference::Directions;
use crate::plan::Optics;
use crate::surface::HeightField;

use super::{Cost, Form, Twin};

pub use directional::{DIRECTIONAL, Directional, PROBES};

/// A function of a shader. It has the same name in every language.
pub trait Function: Sync {
    /// Its name.
    fn name(&self) -> &'static str;

    /// Name of the function with the same arguments that returns tristimulus values.
    fn tristimulus_name(&self) -> &'static str;

    /// Arguments and result in WGSL, as written after the name.
    fn signature(&self) -> &'static str;

    /// Meaning of the arguments, in words.
    fn arguments(&self) -> &'static str;

    /// Cost of a lit pixel that calls the function once.
    fn cost(&self, form: &Form) -> Cost;

    /// Arguments for testing an integration, with the exact results.
    fn probes(
        &self,
        height: &HeightField,
        rotate_deg: f64,
        optics: &Optics,
    ) -> Result<Vec<ExactProbe>>;

    /// Its algorithm in f64. Returns relative tristimulus values.
    fn evaluate(&self, twin: &Twin<'_>, arguments: Directions) -> [f64; 3];
}

/// Arguments of a probe and their exact result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactProbe {
    /// Directions to the light and to the viewer, with components that are exact in 32-bit floats.
    pub directions: Directions,
    /// Relative tristimulus values, gain included.
    pub xyz: [f64; 3],
}

/// All functions.
pub static FUNCTIONS: [&dyn Function; 1] = [&DIRECTIONAL];
