//! How long variants take on adapters, and how much faster they are than a baseline.
//!
//! The machine is never quiet, so what is promised is the ratio, not the time: baseline and variants are drawn in turns
//! ([`rounds`]), a ratio is formed within each round, and the median of the ratios is given with an interval that assumes
//! nothing about how times are distributed ([`stats`]). Shaders of all of them run with the same run-time checks.
//!
//! Clock and statistics need no driver; drawing does.

pub mod clock;
pub mod result;
pub mod rounds;
pub mod scaling;
pub mod stats;
pub mod surface;

pub mod driver;
pub mod yardstick;
