//! Ways to evaluate a variant.

#[cfg(feature = "gpu")]
pub mod gpu;
