//! Whether a driver runs a shader rightly: a few probes of the variant, compared with its twin before the first result.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::field::comparison_directions::pool;
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::runner::Placement;
use diffraction_shaders::variant::{Twin, probe_tolerances};

use super::driver::{Driver, DriverRunner, Prepared, probe};
use super::limits;

/// Directions of each kind (near the mirror direction, on strong orders, elsewhere) that are compared.
const OF_EACH_KIND: usize = 4;

/// Compares a driver's colours of a few lit directions with those of the variant's twin. It is an error, a finding, if one
/// of them is outside the tolerance of the variant's probes. Time: a transform of the heights, some hundred directions in
/// f64, and one small picture.
pub fn check<D: Driver>(prepared: &Prepared<'_>, driver: &D) -> Result<()> {
    let (directions, expected) = handful(prepared);
    let got = probe(prepared, driver, &prepared.spectrum, &directions, &|_| ())?;
    let tolerances = probe_tolerances(&prepared.form, &expected, &expected);
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
    let Directions { wi, wr } = directions[first];
    let cause = format!(
        "gives wrong colours for {}: {count} of {} probes are outside their tolerance; with the light at {wi:.4} and the \
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

/// The brightest directions of each kind, with the twin's colours.
fn handful(prepared: &Prepared<'_>) -> (Vec<Directions>, Vec<[f64; 3]>) {
    let Placement { height, rotate_deg, variant } = prepared.placement;
    // what the shader reads: a table of 32-bit floats is within its tolerance as it is, and may be too large to copy
    let is_exact = prepared.terms.format.is_single();
    let rounded = (!is_exact).then(|| prepared.terms.clone().rounded());
    let twin = Twin {
        form: &prepared.form,
        terms: rounded.as_ref().unwrap_or(&prepared.terms),
        spectrum: &prepared.spectrum,
        coefficients: &prepared.coefficients,
        optics: &variant.optics,
        rotate_deg,
    };
    let mut chosen = Vec::new();
    for kind in pool(height, &variant.optics, rotate_deg) {
        let mut colours: Vec<(Directions, [f64; 3])> =
            kind.into_iter().map(|d| (d, twin.tristimulus(d))).collect();
        colours.sort_by(|a, b| b.1[1].total_cmp(&a.1[1]));
        chosen.extend(colours.into_iter().take(OF_EACH_KIND));
    }
    chosen.into_iter().unzip()
}
