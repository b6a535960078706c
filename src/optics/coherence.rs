//! The coherence window, and the scale relative to a white diffuser that follows from it.

use crate::error::Result;
use crate::optics::Matter;
use crate::plan::{CoherenceScaling, Optics, Window};

/// Standard deviation of the coherence window, µm, at a wavelength: `ℓc/4`, times `λ/550 nm` where the source has a
/// fixed angular size.
pub fn window_sigma_um(window: impl Into<Window>, lambda_nm: f64) -> f64 {
    let window = window.into();
    window.coherence_um / 4.0
        * match window.coherence_scaling {
            CoherenceScaling::Fixed => 1.0,
            CoherenceScaling::Wavelength => lambda_nm / REFERENCE_NM,
        }
}

/// Wavelength at which a coherence length is stated, nm.
pub const REFERENCE_NM: f64 = 550.0;

/// Radiance relative to a white diffuser per unit of ρ, under the coherence window of the optics.
pub fn diffuser_scale(optics: &Optics) -> Result<f64> {
    Ok(Matter::new(optics)?.diffuser_scale(window_sigma_um(optics, REFERENCE_NM)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diffuser_scale_of_filtered_sunlight() {
        let scale = diffuser_scale(&Optics::standard()).expect("a dielectric");
        assert!((scale - 1378.0).abs() < 1.0);
    }
}
