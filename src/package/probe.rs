//! `probe.json`: directions with their colours, to test a shader that was built into an engine.
//!
//! The directions and their exact colours depend on the surface and its optics, and are the same for all variants
//! there. `expected` is the result of the variant's own algorithm in f64 on its packed tables. A shader that is
//! integrated correctly returns it within `tolerance`, however far the variant is from `exact`.

use rayon::prelude::*;
use serde::Serialize;

use crate::encode::json_line;
use crate::error::Result;
use crate::field::reference::Directions;
use crate::optics::colour::to_rgb;
use crate::package::manifest::SCHEMA_VERSION;
use crate::plan::Colour;
use crate::shader::template::GENERATED;
use crate::variant::{ExactProbe, Form, Function, Twin, probe_tolerances};

/// Relative tolerance of the numbers in a `probe.json` between processors.
///
/// Nearly all numbers agree to 1e-9, like other JSON. The exceptions are dim directions on the flank of a lobe: there
/// `exp(-|f - f_rs|²/2σf²)`, or a sum that cancels, is small, and the last digits of a sine or a transform weigh up to
/// a thousand times as much. The tolerance is still at most a tenth of the tolerance of shaders.
pub const TOLERANCE: f64 = 1e-6;

/// The numbers of probes in storage order: nine per probe.
pub fn to_numbers(probes: &[ExactProbe]) -> Vec<f64> {
    let numbers = |e: &ExactProbe| [e.directions.wi.to_array(), e.directions.wr.to_array(), e.xyz];
    probes.iter().flat_map(numbers).flatten().collect()
}

/// The inverse of [`to_numbers`].
pub fn from_numbers(numbers: &[f64]) -> Vec<ExactProbe> {
    let (probes, _) = numbers.as_chunks::<9>();
    let probe = |&[a, b, c, d, e, f, x, y, z]: &[f64; 9]| ExactProbe {
        directions: Directions { wi: [a, b, c].into(), wr: [d, e, f].into() },
        xyz: [x, y, z],
    };
    probes.iter().map(probe).collect()
}

/// Results of a variant's algorithm in f64 (relative tristimulus values), computed on all cores.
pub fn expected(function: &dyn Function, twin: &Twin<'_>, probes: &[ExactProbe]) -> Vec<[f64; 3]> {
    probes.par_iter().map(|probe| function.evaluate(twin, probe.directions)).collect()
}

/// The text of `probe.json`. It takes negligible time.
pub fn json(
    surface: &str,
    variant: &str,
    colour: Colour,
    form: &Form,
    probes: &[ExactProbe],
    expected: &[[f64; 3]],
) -> Result<String> {
    #[derive(Serialize)]
    struct Xyz {
        xyz: [f64; 3],
    }
    #[derive(Serialize)]
    struct Expected {
        xyz: [f64; 3],
        rgb: [f64; 3],
    }
    #[derive(Serialize)]
    struct Probe {
        wi: [f64; 3],
        wr: [f64; 3],
        exact: Xyz,
        expected: Expected,
        tolerance: f64,
    }
    let colours: Vec<[f64; 3]> = probes.iter().map(|probe| probe.xyz).collect();
    let lines = probes.iter().zip(expected).zip(probe_tolerances(form, &colours, expected));
    let lines = lines.map(|((probe, &xyz), tolerance)| {
        let Directions { wi, wr } = probe.directions;
        let probe = Probe {
            wi: wi.to_array(),
            wr: wr.to_array(),
            exact: Xyz { xyz: probe.xyz },
            expected: Expected { xyz, rgb: to_rgb(xyz, colour) },
            tolerance,
        };
        json_line(format!("{surface} {variant} probe.json"), &probe)
    });
    let lines: Vec<String> = lines.collect::<Result<_>>()?;
    let lines = lines.join(",\n    ");
    Ok(format!(
        "{{\n  \"generated_by\": {generated_by},\n  \"schema_version\": {SCHEMA_VERSION},\n  \"surface\": \"{surface}\",\n  \
         \"variant\": \"{variant}\",\n  \"probes\": [\n    {lines}\n  ]\n}}\n",
        generated_by = serde_json::Value::from(GENERATED),
    ))
}
