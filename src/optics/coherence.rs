//! The coherence window.

use crate::plan::{CoherenceScaling, Window};

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
