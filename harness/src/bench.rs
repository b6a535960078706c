//! Times of variants on adapters, and ratios to a baseline.
//!
//! The machine always has other load. So the reliable result is the ratio, not the time: baseline and variants are drawn in
//! turns ([`rounds`]), each round gives a ratio, and the result is the median of the ratios, with an interval that assumes
//! nothing about the distribution of times ([`stats`]). All shaders run with the same run-time checks.
//!
//! Clock and statistics need no driver. Drawing does.

pub mod clock;
pub mod result;
pub mod rounds;
pub mod scaling;
pub mod stats;
pub mod surface;

pub mod driver;
pub mod yardstick;
