//! Whether a driver runs a shader rightly: a few probes of the variant, compared with its twin before the first result.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::field::comparison_directions::pool;
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::light::{Filtered, Sky};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::tables::Table;
use diffraction_shaders::variant::{
    Arguments, Around, FunctionKind, Pattern, Twin, light_tolerance, probe_tolerances, probes_of,
};
use glam::DVec3;

use super::driver::{Call, Driver, DriverRunner, Prepared, probe_calls};
use super::limits;

/// Directions of each kind (near the mirror direction, on strong orders, elsewhere) that are compared.
const OF_EACH_KIND: usize = 4;

/// Compares a driver's colours of a few lit directions with those of the variant's twin, and radiances under lights with a
/// size if the variant has functions for them. It is an error, a finding, if one of them is outside the tolerance of the
/// variant's probes. Time: a transform of the heights, some hundred directions in f64, and one small picture.
pub fn check<D: Driver>(prepared: &Prepared<'_>, driver: &D) -> Result<()> {
    let (calls, expected) = handful(prepared);
    let tolerances = probe_tolerances(&prepared.form, &expected, &expected);
    let mut groups = vec![Group { around: None, calls, expected, tolerances }];
    groups.extend(lit(prepared)?);
    let (mut calls, mut expected, mut tolerances, mut got) = (vec![], vec![], vec![], vec![]);
    for group in groups {
        let around = group.around.as_ref();
        got.extend(probe_calls(
            prepared,
            driver,
            &prepared.spectrum,
            &group.calls,
            around,
            &|_| (),
        )?);
        calls.extend(group.calls);
        expected.extend(group.expected);
        tolerances.extend(group.tolerances);
    }
    let apart = |(a, b): (&[f64; 3], &[f64; 3])| {
        // a maximum that keeps what is not a number
        (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, |max: f64, d| if d <= max { max } else { d })
    };
    let distances: Vec<f64> = got.iter().zip(&expected).map(apart).collect();
    let agrees = |i: &usize| distances[*i] <= tolerances[*i];
    // what is not a number does not agree either
    let wrong = |i: &usize| !agrees(i);
    let count = (0..distances.len()).filter(wrong).count();
    let Some(first) = (0..distances.len()).find(wrong) else { return Ok(()) };
    let Placement { variant, .. } = prepared.placement;
    let (light, wr) = (place(&calls[first].0), calls[first].0.wr());
    let cause = format!(
        "gives wrong colours for {}: {count} of {} probes are outside their tolerance; with the {light} and the \
         viewer at {wr:.4} it gives XYZ {:.6?}, right is {:.6?}",
        variant.name,
        distances.len(),
        got[first],
        expected[first],
    );
    let route = driver.route();
    let remedy = format!(
        "{}; --runner twin computes without a driver; --unchecked skips this check",
        limits::likely_cause(&route, prepared)
    );
    Err(Error::new(route, cause).remedy(remedy).finding())
}

impl<'a, D: Driver> DriverRunner<'a, D> {
    /// The runner, if its driver passes [`check`] with this shader.
    pub fn checked(self) -> Result<DriverRunner<'a, D>> {
        check(&self.prepared, &self.driver)?;
        Ok(self)
    }
}

/// Where the light of a call is, in words.
fn place(call: &Arguments) -> String {
    let of = |colour: Option<DVec3>| {
        colour.map_or_else(String::new, |colour| format!(" of the colour {colour:.3}"))
    };
    match call {
        Arguments::Direction(Directions { wi, .. }) => format!("light at {wi:.4}"),
        Arguments::Spread { directions: Directions { wi, .. }, spread } => {
            format!("light at {wi:.4}, lobes widened by {spread:.4}")
        }
        Arguments::Disc { axis, radius_rad, colour, .. } => {
            let wide = 2.0 * radius_rad.to_degrees();
            format!("disc of {wide:.2}° at {axis:.4}{}", of(*colour))
        }
        Arguments::Rectangle { corners, colour, .. } => {
            format!("quadrilateral {corners:.4?}{}", of(*colour))
        }
        Arguments::Environment { .. } => "surroundings of a probe".to_owned(),
        Arguments::Path { random, .. } => format!("path of the numbers {random:.4}"),
    }
}

/// Calls that have the same surroundings, or none.
struct Group {
    around: Option<Filtered>,
    calls: Vec<Call>,
    /// Results of the twin.
    expected: Vec<[f64; 3]>,
    tolerances: Vec<f64>,
}

/// The probes of functions of lights with a size.
fn lit(prepared: &Prepared<'_>) -> Result<Vec<Group>> {
    let Placement { height, rotate_deg, variant } = prepared.placement;
    let functions = prepared.form.functions();
    let is_probed = |kind| kind != FunctionKind::Direction || prepared.form.has_pattern();
    let sized = functions.into_iter().filter(|f| is_probed(f.kind()));
    let mut skies: Vec<(Option<Sky>, Vec<Call>)> = vec![(None, Vec::new())];
    for function in sized {
        for probe in probes_of(function, variant, height, rotate_deg)? {
            let (sky, call) = match probe.arguments {
                Arguments::Environment { around: Around::Sky(sky), wr } => {
                    (Some(sky), Arguments::Environment { around: Around::Host, wr })
                }
                call => (None, call),
            };
            let call = (call, probe.pattern);
            match skies.iter_mut().find(|(known, _)| *known == sky) {
                Some((_, calls)) => calls.push(call),
                None => skies.push((sky, vec![call])),
            }
        }
    }
    // its tables are of 32-bit floats
    let twin = twin(prepared, &prepared.terms);
    let group = |(sky, calls): (Option<Sky>, Vec<Call>)| {
        // the levels that the shader reads, so that their own error does not count
        let around = sky.as_ref().map(|sky| Filtered::of(sky));
        let twin = Twin { surroundings: around.as_ref().map(|around| around as _), ..twin };
        let result =
            |(call, pattern): &Call| twin.evaluate_on(pattern, *call).unwrap_or([f64::NAN; 3]);
        let expected: Vec<[f64; 3]> = calls.iter().map(result).collect();
        let allowed = |((call, _), expected): (&Call, &[f64; 3])| {
            let call = match sky {
                Some(sky) => Arguments::Environment { around: Around::Sky(sky), wr: call.wr() },
                None => *call,
            };
            light_tolerance(&prepared.form, &call, expected)
        };
        let tolerances = calls.iter().zip(&expected).map(allowed).collect();
        Group { around, calls, expected, tolerances }
    };
    Ok(skies.into_iter().map(group).collect())
}

/// The variant's twin with a table of terms.
fn twin<'a>(prepared: &'a Prepared<'_>, terms: &'a Table) -> Twin<'a> {
    let rotate_deg = prepared.placement.rotate_deg;
    Twin {
        form: &prepared.form,
        terms,
        spectrum: &prepared.spectrum,
        coefficients: &prepared.coefficients,
        streaks: &prepared.streaks,
        paths: &prepared.paths,
        rotate_deg,
        surroundings: None,
    }
}

/// The brightest directions of each kind, with the twin's colours.
fn handful(prepared: &Prepared<'_>) -> (Vec<Call>, Vec<[f64; 3]>) {
    let Placement { height, rotate_deg, variant } = prepared.placement;
    // what the shader reads: a table of 32-bit floats is within its tolerance as it is, and may be too large to copy
    let is_exact = prepared.terms.format.is_single();
    let rounded = (!is_exact).then(|| prepared.terms.clone().rounded());
    let twin = twin(prepared, rounded.as_ref().unwrap_or(&prepared.terms));
    let mut chosen = Vec::new();
    for kind in pool(height, &variant.optics, rotate_deg) {
        let mut colours: Vec<(Directions, [f64; 3])> =
            kind.into_iter().map(|d| (d, twin.tristimulus(d))).collect();
        colours.sort_by(|a, b| b.1[1].total_cmp(&a.1[1]));
        let brightest = colours.into_iter().take(OF_EACH_KIND);
        let call = |d| (Arguments::Direction(d), Pattern::NONE);
        chosen.extend(brightest.map(|(d, xyz)| (call(d), xyz)));
    }
    chosen.into_iter().unzip()
}
