//! What measures and proves the shaders of [`diffraction_shaders`]: drivers, a browser, comparisons, times, reports.
//!
//! Everything here touches the outside world, and the compiler knows nothing of it. The order of the modules below is the
//! order in which they build on each other: a module uses only earlier ones.

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
