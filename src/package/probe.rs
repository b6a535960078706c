//! `probe.json`: directions with their colours, so that who builds a shader into an engine can test the result.
//!
//! The directions and their exact colours belong to a surface and its optics, and are the same for all variants there.
//! `expected` is the variant's own algorithm in f64 on its packed tables; a shader that is built in correctly gives that
//! within `tolerance`, whatever the variant's distance from `exact`.

use rayon::prelude::*;
use serde::Serialize;

use crate::error::{Error, Result};
use crate::field::reference::Directions;
use crate::optics::colour::to_rgb;
use crate::package::manifest::SCHEMA_VERSION;
use crate::plan::Colour;
use crate::shader::template::GENERATED;
use crate::variant::{ExactProbe, Form, Function, Twin, probe_tolerances};

/// Relative tolerance of the numbers in a `probe.json` between processors.
///
/// Most agree to 1e-9, like all JSON, but not all: a dim direction on the flank of a lobe is the small end of
/// `exp(-|f - f_rs|²/2σf²)` or of a sum that cancels, where the last digits of a sine or a transform count up to a thousand
/// times as much. It is still a tenth, or less, of the tolerance that a shader is granted.
pub const TOLERANCE: f64 = 1e-6;

/// The numbers of probes, for storing: nine of each.
pub fn to_numbers(probes: &[ExactProbe]) -> Vec<f64> {
    let numbers = |e: &ExactProbe| [e.directions.wi.to_array(), e.directions.wr.to_array(), e.xyz];
    probes.iter().flat_map(numbers).flatten().collect()
}

/// The reverse of [`to_numbers`].
pub fn from_numbers(numbers: &[f64]) -> Vec<ExactProbe> {
    let (probes, _) = numbers.as_chunks::<9>();
    let probe = |&[a, b, c, d, e, f, x, y, z]: &[f64; 9]| ExactProbe {
        directions: Directions { wi: [a, b, c].into(), wr: [d, e, f].into() },
        xyz: [x, y, z],
    };
    probes.iter().map(probe).collect()
}

/// What a variant's algorithm gives in f64, relative tristimulus values, on all cores.
pub fn expected(function: &dyn Function, twin: &Twin<'_>, probes: &[ExactProbe]) -> Vec<[f64; 3]> {
    probes.par_iter().map(|probe| function.evaluate(twin, probe.directions)).collect()
}

/// `probe.json`. Time: none worth counting.
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
    let lines = probes.iter().zip(expected).zip(probe_tolerances(form, expected));
    let lines = lines.map(|((probe, &xyz), tolerance)| {
        let Directions { wi, wr } = probe.directions;
        let probe = Probe {
            wi: wi.to_array(),
            wr: wr.to_array(),
            exact: Xyz { xyz: probe.xyz },
            expected: Expected { xyz, rgb: to_rgb(xyz, colour) },
            tolerance,
        };
        serde_json::to_string(&probe)
            .map_err(|e| Error::new(variant, "has a probe without a number").source(e))
    });
    let lines: Vec<String> = lines.collect::<Result<_>>()?;
    let lines = lines.join(",\n    ");
    Ok(format!(
        "{{\n  \"generated_by\": {generated_by},\n  \"schema_version\": {SCHEMA_VERSION},\n  \"surface\": \"{surface}\",\n  \
         \"variant\": \"{variant}\",\n  \"probes\": [\n    {lines}\n  ]\n}}\n",
        generated_by = serde_json::Value::from(GENERATED),
    ))
}
