//! `probe.json`: directions with their colours, to test a shader that was built into an engine.
//!
//! The directions and their exact colours depend on the surface and its optics, and are the same for all variants
//! there. `expected` is the result of the variant's own algorithm in f64 on its packed tables. A shader that is
//! integrated correctly returns it within `tolerance`, however far the variant is from `exact`.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::encode::json_line;
use crate::error::Result;
use crate::field::reference::Directions;
use crate::light::Sky;
use crate::optics::colour::to_rgb;
use crate::package::manifest::SCHEMA_VERSION;
use crate::plan::{Colour, Variant};
use crate::shader::template::GENERATED;
use crate::variant::{
    Arguments, Around, ExactProbe, Form, Function, Pattern, Twin, light_tolerance, probe_tolerances,
};

/// Relative tolerance of the numbers in a `probe.json` between processors.
///
/// Nearly all numbers agree to 1e-9, like other JSON. The exceptions are dim directions on the flank of a lobe: there
/// `exp(-|f - f_rs|²/2σf²)`, or a sum that cancels, is small, and the last digits of a sine or a transform weigh up to
/// a thousand times as much. The tolerance is still at most a tenth of the tolerance of shaders.
pub const TOLERANCE: f64 = 1e-6;

/// The probes of a function.
#[derive(Clone)]
pub struct Probed {
    /// The function.
    pub function: &'static dyn Function,
    /// Arguments with exact results.
    pub exact: Vec<ExactProbe>,
    /// Results of the variant's algorithm in f64 on its packed tables.
    pub expected: Vec<[f64; 3]>,
}

impl Probed {
    /// The exact results.
    pub fn exact_xyz(&self) -> Vec<[f64; 3]> {
        self.exact.iter().map(|probe| probe.xyz).collect()
    }
}

/// Numbers of a probe of a function in storage: arguments and exact result.
pub fn width(function: &dyn Function) -> usize {
    Arguments::width(function.kind()) + 3
}

/// The numbers of probes in storage order.
pub fn to_numbers(probes: &[ExactProbe]) -> Vec<f64> {
    let numbers = |e: &ExactProbe| [e.arguments.to_numbers(), e.xyz.to_vec()].concat();
    probes.iter().flat_map(numbers).collect()
}

/// The inverse of [`to_numbers`] for a variant, whose patterns follow from its place.
pub fn from_numbers(
    function: &dyn Function,
    variant: &Variant,
    numbers: &[f64],
) -> Vec<ExactProbe> {
    let patterns = variant.pattern.then(|| Pattern::probes(variant));
    let probe = |(i, numbers): (usize, &[f64])| {
        let pattern = patterns.map_or(Pattern::NONE, |patterns| patterns[i % patterns.len()]);
        let (arguments, xyz) = numbers.split_at(numbers.len() - 3);
        let arguments = Arguments::from_numbers(function.kind(), arguments)?;
        Some(ExactProbe { arguments, pattern, xyz: *xyz.first_chunk()? })
    };
    numbers.chunks_exact(width(function)).enumerate().filter_map(probe).collect()
}

/// Results of a variant's algorithm in f64, computed on all cores.
pub fn expected(twin: &Twin<'_>, probes: &[ExactProbe]) -> Vec<[f64; 3]> {
    // a form has all functions that it lists
    let result = |probe: &ExactProbe| {
        twin.evaluate_on(&probe.pattern, probe.arguments).unwrap_or([f64::NAN; 3])
    };
    probes.par_iter().map(result).collect()
}

/// The text of `probe.json`. It takes negligible time.
pub fn json(surface: &str, variant: &Variant, form: &Form, probed: &[Probed]) -> Result<String> {
    let place = format!("{surface} {} probe.json", variant.name);
    let colour = variant.optics.colour;
    let (mut probes, mut lights) = (Vec::new(), Vec::new());
    for Probed { function, exact, expected } in probed {
        let colours: Vec<[f64; 3]> = exact.iter().map(|probe| probe.xyz).collect();
        let tolerances = probe_tolerances(form, &colours, expected);
        for ((probe, &xyz), tolerance) in exact.iter().zip(expected).zip(tolerances) {
            let (exact, expected) = (Xyz { xyz: probe.xyz }, Expected::new(xyz, colour));
            let pattern = variant.pattern.then(|| probe.pattern.argument().to_array());
            match probe.arguments {
                Arguments::Direction(Directions { wi, wr }) => {
                    let (wi, wr) = (wi.to_array(), wr.to_array());
                    let probe = Probe { wi, wr, pattern, exact, expected, tolerance };
                    probes.push(json_line(&place, &probe)?);
                }
                arguments => {
                    let (mut axis, mut radius, mut corners, mut sky) = (None, None, None, None);
                    let (mut random, mut colour) = (None, None);
                    let (mut wi, mut spread) = (None, None);
                    let tolerance = light_tolerance(form, &arguments, &xyz);
                    match arguments {
                        Arguments::Spread { directions, spread: width } => {
                            (wi, spread) = (Some(directions.wi.to_array()), Some(width));
                        }
                        Arguments::Disc { axis: to, radius_rad, colour: of, .. } => {
                            (axis, radius) = (Some(to.to_array()), Some(radius_rad));
                            colour = of;
                        }
                        Arguments::Rectangle { corners: to, colour: of, .. } => {
                            corners = Some(to.map(|corner| corner.to_array()));
                            colour = of;
                        }
                        Arguments::Environment { around: Around::Sky(seen), .. } => {
                            sky = Some(SkyOf::new(&seen));
                        }
                        Arguments::Path { sky: seen, random: numbers, .. } => {
                            sky = Some(SkyOf::new(&seen));
                            random = Some(numbers.to_array());
                        }
                        Arguments::Direction(_) | Arguments::Environment { .. } => {}
                    }
                    let (function, wr) = (function.name(), arguments.wr().to_array());
                    let light = OfLight {
                        function,
                        wi,
                        spread,
                        axis,
                        radius,
                        corners,
                        colour: colour.map(|colour| colour.to_array()),
                        sky,
                        random,
                        wr,
                        pattern,
                        exact,
                        expected,
                        tolerance,
                    };
                    lights.push(json_line(&place, &light)?);
                }
            }
        }
    }
    let lines = |lines: Vec<String>| lines.join(",\n    ");
    let lights = match lights.is_empty() {
        true => String::new(),
        false => format!(",\n  \"lights\": [\n    {}\n  ]", lines(lights)),
    };
    Ok(format!(
        "{{\n  \"generated_by\": {generated_by},\n  \"schema_version\": {SCHEMA_VERSION},\n  \"surface\": \"{surface}\",\n  \
         \"variant\": \"{}\",\n  \"probes\": [\n    {}\n  ]{lights}\n}}\n",
        variant.name,
        lines(probes),
        generated_by = serde_json::Value::from(GENERATED),
    ))
}

#[derive(Serialize)]
struct Xyz {
    xyz: [f64; 3],
}

#[derive(Serialize)]
struct Expected {
    xyz: [f64; 3],
    rgb: [f64; 3],
}

impl Expected {
    fn new(xyz: [f64; 3], colour: Colour) -> Expected {
        Expected { xyz, rgb: to_rgb(xyz, colour) }
    }
}

#[derive(Serialize)]
struct Probe {
    wi: [f64; 3],
    wr: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    pattern: Option<[f64; 4]>,
    exact: Xyz,
    expected: Expected,
    tolerance: f64,
}

/// A probe of a function of lights with a size.
#[derive(Serialize)]
struct OfLight {
    function: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    wi: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    spread: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    axis: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    corners: Option<[[f64; 3]; 4]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    colour: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sky: Option<SkyOf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    random: Option<[f64; 3]>,
    wr: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    pattern: Option<[f64; 4]>,
    exact: Xyz,
    expected: Expected,
    tolerance: f64,
}

/// The sky of a probe: `constant + Σ radiance·σ²/(σ² + s²)·exp(-(1 - d·axis)/(σ² + s²))` from a direction d, blurred over s.
#[derive(Serialize)]
struct SkyOf {
    constant: [f64; 3],
    lobes: Vec<LobeOf>,
}

#[derive(Serialize)]
struct LobeOf {
    axis: [f64; 3],
    sigma: f64,
    radiance: [f64; 3],
}

impl SkyOf {
    fn new(sky: &Sky) -> SkyOf {
        let lit = sky.lobes.iter().filter(|lobe| lobe.radiance != DVec3::ZERO);
        let lobes = lit.map(|lobe| LobeOf {
            axis: lobe.axis.to_array(),
            sigma: lobe.sigma_rad,
            radiance: lobe.radiance.to_array(),
        });
        SkyOf { constant: sky.constant.to_array(), lobes: lobes.collect() }
    }
}
