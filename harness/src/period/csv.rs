//! Samples as CSV.

use std::fmt::Write;

use super::Measurement;

/// CSV with the header `wavelength_nm,theta_r_deg,response` and one line for each evaluated sample, by wavelength, then angle.
/// Numbers are exact. The angles are a subset of the grid, dense around peaks.
pub fn csv(measurement: &Measurement) -> String {
    let mut text = "wavelength_nm,theta_r_deg,response\n".to_owned();
    for row in &measurement.rows {
        for (theta_deg, response) in &row.samples {
            // writing to a string cannot fail
            let _ = writeln!(text, "{:?},{theta_deg:?},{response:?}", row.lambda_nm);
        }
    }
    text
}
