//! The period of a surface as a variant sees it: from the response over wavelength and viewing angle.
//!
//! Light falls in at `θi`, `φi`. The viewer stays in the plane of incidence; `θr` is **signed**: positive towards the
//! mirror direction (`φr = φi + 180°`), negative on the light's own side. With `φi = 0` and no rotation the plane holds
//! the surface's x axis, and `u = sin θr - sin θi`, so that order `m` lies at `sin θr = sin θi + m λ/d`.
//!
//! For every wavelength the angle of the largest response (`|P|²`, without the gain) within half and one and a half times
//! the expected place of the first order becomes a period, `d = λ/|sin θr - sin θi|`; mean and standard deviation over
//! wavelengths are what is reported.
//!
//! **The efficiency envelope.** An order's strength changes over the width of its lobe, with `w` and, for replicas of
//! a cell, with the cell's own transform. That pulls its maximum off the grating equation, and it should. The yardstick
//! is therefore the same estimator on the closed form of the grating ([`ClosedForm`]), not the grating equation.

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

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Protocol {
    /// Angle of incidence, degrees, below 90.
    pub theta_i_deg: f64,
    /// Direction of the light about the normal, from `+x`, degrees.
    pub phi_i_deg: f64,
    /// Wavelengths.
    pub wavelengths: Wavelengths,
    /// The period around which is searched, µm.
    pub expected_um: f64,
    /// Sample the whole half circle of viewing angles, for pictures; else only where is searched.
    pub whole: bool,
}

impl Protocol {
    /// The pair of directions for a signed viewing angle, degrees.
    pub fn directions(&self, theta_r_deg: f64) -> Directions {
        Directions {
            wi: direction(self.theta_i_deg, self.phi_i_deg),
            wr: direction(theta_r_deg, self.phi_i_deg + 180.0),
        }
    }

    /// `sin θr` of order `m` of a grating of the expected period; `None` where it is evanescent.
    pub fn order(&self, m: i32, lambda_nm: f64) -> Option<f64> {
        let sin = self.sin_theta_i() + f64::from(m) * lambda_nm * 1e-3 / self.expected_um;
        (sin.abs() <= 1.0).then_some(sin)
    }

    fn sin_theta_i(&self) -> f64 {
        self.theta_i_deg.to_radians().sin()
    }
}

/// The responses of one wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct WavelengthRow {
    /// Wavelength, nm.
    pub lambda_nm: f64,
    /// Signed viewing angle, degrees, ascending, and `|P|²`.
    pub samples: Vec<(f64, f64)>,
    /// The peak of the first order, if there is one.
    pub peak: Option<Peak>,
}

/// All wavelengths, and what follows from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// By ascending wavelength, those of evanescent first orders included.
    pub rows: Vec<WavelengthRow>,
    /// Mean period over wavelengths with a peak, nm; `NaN` where there is none.
    pub period_nm: f64,
    /// Standard deviation (of the population) of the same, nm.
    pub sd_nm: f64,
    /// Wavelengths with a peak.
    pub points: usize,
    /// Wavelengths whose first order is evanescent on both sides.
    pub evanescent: usize,
    /// Wavelengths without a maximum where the first order is expected.
    pub flat: usize,
    /// Mean response at the peaks; 0 where there is none.
    pub weight: f64,
    /// Evaluations of the response.
    pub evaluations: usize,
}

/// Measures a response, given as `|P|²` for a wavelength, nm, and signed viewing angles, degrees.
///
/// `extent_um` is the greatest distance over which the surface's points interfere ([`extent_um`]): it bounds how narrow a
/// lobe can be, and so where the grid of [`GRID_DEG`] need not be filled to find the same maximum.
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
        Some(at) => Err(fail(format!("is {} at {}°", responses[at], angles[at]))),
        None => Ok(responses),
    }
}
