//! The algorithms of the templates in f64, function by function.
//!
//! `twin/x.rs` stands beside `templates/x.wgsl` with the same function names. What every mode shares is not written
//! twice: the f64 form of `gain.wgsl` is [`crate::optics`], that of the map's geometry [`crate::frame`].

pub mod full;
