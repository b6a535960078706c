//! A shader compiler for structural colour: from a height field to validated diffraction shaders with a stated error.
//!
//! The order of the modules below is the order of the pipeline: a module uses only earlier ones.
//!
//! # Conventions
//!
//! - **Frame.** Normal `n = (0, 0, 1)`, `x` along the tangent, `y` along the bitangent. `wi` points from the surface to the
//!   light, `wr` to the viewer, both unit; `(u, v, w) = -wi - wr`, so `w` is in `[-2, 0]` and the mirror direction is
//!   `u = v = 0`.
//! - **Heights** are in µm, positive outwards. Row 0 is the top of the picture, `+y` is up: pixel (col, row) lies at
//!   `x = col·dx - Lx/2`, `y = (M-1-row)·dy - Ly/2`. The origin of all phases and of the coherence window is the centre of
//!   the patch, which tiles the plane.
//! - **Units.** µm inside formulas, nm for wavelengths in names; `k = 2π/λ`, `z = k·w`; spatial frequency
//!   `f = (u, v)/λ` in cycles per µm.
//! - **Transforms** are MATLAB's `ifft2`: `1/(NM) Σ … exp(+2πi …)`.
//! - **Coherence.** Gaussian window of standard deviation `σs = ℓc/4`; its spectrum has peak 1 and standard deviation
//!   `σf = 1/(2π σs)`. `single`: `|Σ_rs c_rs ĝ(f - f_rs)|²`; `ensemble`: `Σ_rs |c_rs|² ĝ(f - f_rs)²`.
//! - **ρ** is relative to a mirror at normal incidence in its mirror direction. Tristimulus values are relative to the
//!   illuminant's white, `Y = 1`; linear sRGB, white point D65, not clamped.
//!
//! # Limits of the model
//!
//! Scalar theory, single scattering, heights well below what a rigorous solver needs: a lamellar grating 0.1 µm deep at
//! 550 nm has a scalar zero order of 0.228, a rigorous one of 0.324 (TE) and 0.152 (TM). Stam's obliquity factor is the mean,
//! in amplitude, of the exact first-order TE and TM factors. Without shadowing the gain diverges at grazing exit. A scan that
//! is not periodic shows its seam as a streak in `ensemble`, unless it is cropped to a near-period or tapered.
//!
//! # Sources
//!
//! J. Stam, *Diffraction shaders* (SIGGRAPH 1999), for the model; C. Schlick (1994) for the reflectance; K. Torrance and
//! E. Sparrow (1967) for V-cavities; CIE 015 and IEC 61966-2-1 for colour.

#![forbid(unsafe_code)]

pub mod error;
pub mod diagnostic;
pub mod hash;
pub mod random;
pub mod defines;
pub mod plan;
pub mod encode;
pub mod surface;
pub mod optics;
pub mod input;
pub mod field;
pub mod tables;
pub mod variant;
pub mod survey;
pub mod shader;
pub mod package;
pub mod runner;
