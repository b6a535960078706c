//! Optics of one direction and wavelength: directions, gain, coherence, spectra and colours.
//!
//! Conventions: the surface normal is `(0, 0, 1)`; `wi` points from the surface to the light, `wr` to the viewer, both
//! unit; `(u, v, w) = -wi - wr`. Angles are degrees: `theta` from the normal, `phi` counter-clockwise from `+x`.

mod directions;
mod gain;
mod medium;
mod matter;
mod coherence;
mod primaries;
pub mod colour;
pub mod spectrum;
pub mod brdf_map;
pub mod colour_difference;

pub use coherence::{REFERENCE_NM, window_sigma_um};
pub use directions::{direction, path_difference};
pub use gain::{fresnel_ratio, normal_reflectance, shadowing};
pub use matter::{Facing, Matter, diffuser_scale, notes, reflectances};
pub use medium::Index;
pub use primaries::primary_shares;
