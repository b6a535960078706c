//! The coherence window, and the scale relative to a white diffuser that follows from it.

use crate::optics::normal_reflectance;
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

/// Radiance relative to a white diffuser per unit of ρ: `s = 4π² R0 σs²/λ0²`, λ0 = 550 nm.
pub fn diffuser_scale(optics: &Optics) -> f64 {
    let sigma_um = window_sigma_um(optics, REFERENCE_NM);
    let ratio = std::f64::consts::TAU * sigma_um / (REFERENCE_NM * 1e-3);
    normal_reflectance(optics.refractive_index) * ratio * ratio
}

/// The same for a finite number of replicas without a window: `π R0 Ax Ay/λ0²`, with the sides of the whole surface in
/// µm. Both scales are `π R0/(λ0² ∫|P|² df)` of a mirror.
pub fn replica_diffuser_scale(optics: &Optics, [x_um, y_um]: [f64; 2]) -> f64 {
    let area = x_um * y_um / (REFERENCE_NM * 1e-3).powi(2);
    std::f64::consts::PI * normal_reflectance(optics.refractive_index) * area
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diffuser_scale_of_filtered_sunlight() {
        assert!((diffuser_scale(&Optics::standard()) - 1378.0).abs() < 1.0);
    }
}
