//! The period of a surface as a variant shows it, from the response over wavelength and viewing angle.
//!
//! Light comes from `θi`, `φi`. The viewer moves in the plane of incidence. `θr` is **signed**: positive towards the mirror
//! direction (`φr = φi + 180°`), negative on the side of the light. With `φi = 0` and no rotation the plane contains the
//! surface's x axis, and `u = sin θr - sin θi`, so order `m` is at `sin θr = sin θi + m λ/d`.
//!
//! For every wavelength, the angle of the largest response (`|P|²`, without the gain) is searched between 0.5 and 1.5 times
//! the expected distance of the first order. It gives a period, `d = λ/|sin θr - sin θi|`. The result is the mean and the
//! standard deviation over wavelengths.
//!
//! **The efficiency envelope.** An order's strength changes over the width of its lobe, with `w` and, for replicas of a cell,
//! with the cell's own transform. This shifts its maximum away from the grating equation, rightly so. The yardstick is
//! therefore the same estimator on the closed form of the grating ([`ClosedForm`]), not the grating equation.

mod csv;
mod heatmap;
mod estimate;
mod closed_form;
mod respond;
mod search;
mod windows;

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::Wavelengths;

pub use closed_form::{ClosedForm, Lobe};
pub use csv::csv;
pub use estimate::expected_um;
pub use heatmap::{HeatmapText, heatmap};
pub use respond::{exact, extent_um, profile, runner, yardstick};
pub use search::Peak;
pub use windows::{Crop, Spread, layout, spread};

/// The grid of viewing angles, degrees.
pub const GRID_DEG: f64 = 0.01;

/// The parameters of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Protocol {
    /// Angle of incidence, degrees, below 90.
    pub theta_i_deg: f64,
    /// Angle of the light about the normal, from `+x`, degrees.
    pub phi_i_deg: f64,
    /// Wavelengths.
    pub wavelengths: Wavelengths,
    /// The expected period, around which is searched, µm.
    pub expected_um: f64,
    /// Whether to sample the whole half circle of viewing angles, for pictures, or only the searched range.
    pub whole: bool,
}

impl Protocol {
    /// The directions for a signed viewing angle in degrees.
    pub fn directions(&self, theta_r_deg: f64) -> Directions {
        Directions {
            wi: direction(self.theta_i_deg, self.phi_i_deg),
            wr: direction(theta_r_deg, self.phi_i_deg + 180.0),
        }
    }

    /// `sin θr` of order `m` of a grating with the expected period; `None` if it is evanescent.
    pub fn order(&self, m: i32, lambda_nm: f64) -> Option<f64> {
        let sin = self.sin_theta_i() + f64::from(m) * lambda_nm * 1e-3 / self.expected_um;
        (sin.abs() <= 1.0).then_some(sin)
    }

    fn sin_theta_i(&self) -> f64 {
        self.theta_i_deg.to_radians().sin()
    }
}

/// The responses at one wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct WavelengthRow {
    /// Wavelength, nm.
    pub lambda_nm: f64,
    /// Signed viewing angles in degrees, ascending, each with `|P|²`.
    pub samples: Vec<(f64, f64)>,
    /// The peak of the first order, if there is one.
    pub peak: Option<Peak>,
}

/// The responses at all wavelengths, and the results.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// By ascending wavelength, including those whose first order is evanescent.
    pub rows: Vec<WavelengthRow>,
    /// Mean period over wavelengths with a peak, nm; `NaN` without any.
    pub period_nm: f64,
    /// Standard deviation of the periods (of the population), nm.
    pub sd_nm: f64,
    /// Number of wavelengths with a peak.
    pub points: usize,
    /// Number of wavelengths whose first order is evanescent on both sides.
    pub evanescent: usize,
    /// Number of wavelengths without a maximum in the searched range.
    pub flat: usize,
    /// Mean response at the peaks; 0 without any.
    pub weight: f64,
    /// Number of evaluations of the response.
    pub evaluations: usize,
}

/// Measures a response. `response` returns `|P|²` for a wavelength in nm and signed viewing angles in degrees.
///
/// `extent_um` is the maximum distance over which points of the surface interfere ([`extent_um`]). It gives the minimum width
/// of a lobe, so that the grid of [`GRID_DEG`] need not be evaluated everywhere to find the same maximum.
pub fn measure(
    protocol: &Protocol,
    extent_um: f64,
    mut respond: impl FnMut(f64, &[f64]) -> Result<Vec<f64>>,
) -> Result<Measurement> {
    let (mut rows, mut evanescent, mut flat, mut evaluations) = (Vec::new(), 0, 0, 0);
    for lambda_nm in protocol.wavelengths.nodes_nm() {
        let stride = search::stride(extent_um, lambda_nm);
        let samples = search::scan(protocol, lambda_nm, stride, |angles| {
            evaluations += angles.len();
            checked(lambda_nm, angles, respond(lambda_nm, angles)?)
        })?;
        let exists = protocol.order(-1, lambda_nm).or(protocol.order(1, lambda_nm)).is_some();
        let peak = if exists { search::peak(protocol, lambda_nm, &samples) } else { None };
        evanescent += usize::from(!exists);
        flat += usize::from(exists && peak.is_none());
        let samples = samples.into_iter().map(|(i, r)| (search::angle_deg(i), r)).collect();
        rows.push(WavelengthRow { lambda_nm, samples, peak });
    }
    let peaks: Vec<Peak> = rows.iter().filter_map(|row| row.peak).collect();
    let mean = |of: &dyn Fn(&Peak) -> f64| peaks.iter().map(of).sum::<f64>() / peaks.len() as f64;
    let period_nm = mean(&|p| p.period_nm);
    let sd_nm = mean(&|p| (p.period_nm - period_nm).powi(2)).sqrt();
    let weight = if peaks.is_empty() { 0.0 } else { mean(&|p| p.response) };
    let points = peaks.len();
    Ok(Measurement { rows, period_nm, sd_nm, points, evanescent, flat, weight, evaluations })
}

fn checked(lambda_nm: f64, angles: &[f64], responses: Vec<f64>) -> Result<Vec<f64>> {
    let fail = |cause: String| Error::new(format!("response at {lambda_nm} nm"), cause);
    if responses.len() != angles.len() {
        return Err(fail(format!("{} values for {} angles", responses.len(), angles.len())));
    }
    match responses.iter().position(|r| !r.is_finite()) {
        Some(at) => Err(fail(format!("is not finite: {} at {}°", responses[at], angles[at]))),
        None => Ok(responses),
    }
}
