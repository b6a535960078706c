//! Measures and tests the shaders of [`diffraction_shaders`]: drivers, a browser, comparisons, times, reports.
//!
//! Everything that touches the outside world is here; the compiler does not depend on it. A module uses only modules that
//! stand before it in the list below.

#![deny(unsafe_code)]

pub mod process;
pub mod results;
pub mod drivers;
pub mod scene;
pub mod period;
pub mod bench;
pub mod tune;
pub mod validate;
pub mod compare;
pub mod report;
pub mod commands;
