//! The functions that engines can call in a shader, one file for each. A form lists its functions; text, manifest,
//! probes and cost follow from that.

mod arguments;
mod coloured;
mod directional;
mod disc;
mod environment;
mod lamps;
mod path;
mod rectangle;
mod soft_disc;
mod spread;

use serde::Serialize;

use crate::error::Result;
use crate::optics::Matter;
use crate::plan::{LightFunction, Optics, Variant};
use crate::surface::HeightField;

use super::{Cost, Form, Pattern};

pub use arguments::{Arguments, Around};
pub use coloured::{Coloured, DISC_COLOURED, RECTANGLE_COLOURED};
pub use directional::{DIRECTIONAL, Directional};
pub use disc::{DISC, Disc};
pub use environment::{ENVIRONMENT, Environment, define_surroundings, skies};
pub use path::{PATH, Paths};
pub use rectangle::{RECTANGLE, Rectangle};
pub use soft_disc::{SOFT_DISC, SoftDisc};
pub use spread::{SPREAD, Spread, widened};

/// A function of a shader. It has the same name in every language.
pub trait Function: Sync {
    /// Its name.
    fn name(&self) -> &'static str;

    /// Name of the function with the same arguments that returns tristimulus values.
    fn tristimulus_name(&self) -> &'static str;

    /// Arguments and result in WGSL, as written after the name.
    fn signature(&self) -> &'static str;

    /// The same of the function that returns tristimulus values.
    fn tristimulus_signature(&self) -> &'static str {
        self.signature()
    }

    /// Functions that belong to it, with their signatures, of a form or of any.
    fn further(&self, _: Option<&Form>) -> &'static [(&'static str, &'static str)] {
        &[]
    }

    /// Meaning of the arguments, in words.
    fn arguments(&self) -> &'static str;

    /// The function that it calls and the host defines, with its meaning. `None` if it calls none.
    fn host(&self) -> Option<&'static str> {
        None
    }

    /// Which function it is.
    fn kind(&self) -> FunctionKind;

    /// Its probes: functions with the same name may have others.
    fn probed(&self) -> &'static str {
        self.name()
    }

    /// Unit of its result, in words.
    fn unit(&self, form: &Form) -> &'static str;

    /// Cost of a lit pixel that calls the function once.
    fn cost(&self, form: &Form) -> Cost;

    /// Errors against exact colours that it promises. Empty if the form itself promises them.
    fn errors(&self, _: &Form) -> Vec<StatedError> {
        Vec::new()
    }

    /// Number of its probes.
    fn probe_count(&self) -> usize;

    /// Arguments for testing an integration, with the exact results.
    fn probes(
        &self,
        height: &HeightField,
        rotate_deg: f64,
        optics: &Optics,
    ) -> Result<Vec<ExactProbe>>;
}

/// An error that a function promises.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatedError {
    /// Under which light.
    pub under: String,
    /// Maximum of the 95th percentile of CIEDE2000 against the exact colours, over viewers that see light.
    pub de2000_p95: f64,
}

/// Arguments of a probe and their exact result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactProbe {
    /// With components that are exact in 32-bit floats.
    pub arguments: Arguments,
    /// The texel.
    pub pattern: Pattern,
    /// Tristimulus values in the unit of the function.
    pub xyz: [f64; 3],
}

/// Probes of a function of a variant. With patterns, each has one of the patterns of [`Pattern::probes`], in turn.
pub fn probes_of(
    function: &dyn Function,
    variant: &Variant,
    height: &HeightField,
    rotate_deg: f64,
) -> Result<Vec<ExactProbe>> {
    let optics = &variant.optics;
    if !variant.pattern {
        return function.probes(height, rotate_deg, optics);
    }
    let patterns = Pattern::probes(variant);
    let sets = patterns.map(|pattern| {
        function.probes(&pattern.scaled(height)?, rotate_deg + pattern.angle_deg, optics)
    });
    let sets = sets.into_iter().collect::<Result<Vec<_>>>()?;
    let probe = |i: usize| {
        let of = i % patterns.len();
        ExactProbe { pattern: patterns[of], ..sets[of][i] }
    };
    Ok((0..function.probe_count()).map(probe).collect())
}

/// Functions that functions call and the host defines. Whole shaders define them over textures.
pub const HOSTS: [&str; 1] = ["environment_radiance"];

/// All functions.
pub static FUNCTIONS: [&dyn Function; 8] = [
    &DIRECTIONAL,
    &SPREAD,
    &DISC,
    &DISC_COLOURED,
    &RECTANGLE,
    &RECTANGLE_COLOURED,
    &ENVIRONMENT,
    &PATH,
];

/// Which function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionKind {
    /// `diffraction`.
    Direction,
    /// `diffraction_spread`.
    Spread,
    /// `diffraction_disc`.
    Disc,
    /// `diffraction_disc_coloured`.
    DiscColoured,
    /// `diffraction_rectangle`.
    Rectangle,
    /// `diffraction_rectangle_coloured`.
    RectangleColoured,
    /// `diffraction_environment`.
    Environment,
    /// `diffraction_path`.
    Path,
}

impl FunctionKind {
    /// The function.
    pub fn function(self) -> &'static dyn Function {
        match self {
            FunctionKind::Direction => &DIRECTIONAL,
            FunctionKind::Spread => &SPREAD,
            FunctionKind::Disc => &DISC,
            FunctionKind::DiscColoured => &DISC_COLOURED,
            FunctionKind::Rectangle => &RECTANGLE,
            FunctionKind::RectangleColoured => &RECTANGLE_COLOURED,
            FunctionKind::Environment => &ENVIRONMENT,
            FunctionKind::Path => &PATH,
        }
    }

    /// The word of the plan that asks for it. `None` for the one that comes with tables of wider lobes.
    pub fn word(self) -> Option<LightFunction> {
        match self {
            FunctionKind::Direction => Some(LightFunction::Direction),
            FunctionKind::Spread => None,
            FunctionKind::Disc | FunctionKind::DiscColoured => Some(LightFunction::Disc),
            FunctionKind::Rectangle | FunctionKind::RectangleColoured => {
                Some(LightFunction::Polygon)
            }
            FunctionKind::Environment => Some(LightFunction::Environment),
            FunctionKind::Path => Some(LightFunction::Path),
        }
    }
}

/// The functions that a word of the plan asks for.
pub fn functions_of(word: LightFunction) -> impl Iterator<Item = &'static dyn Function> {
    FUNCTIONS.into_iter().filter(move |function| function.kind().word() == Some(word))
}

/// Radiance of the light of a call, seen in a mirror of the material at normal incidence, relative to a white. Probes'
/// tolerances are relative to it.
pub fn mirrored(arguments: &Arguments, matter: &Matter) -> f64 {
    lamps::mirrored(arguments, matter)
}
