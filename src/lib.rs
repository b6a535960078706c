//! A shader compiler for structural colour.
//!
//! The order of the modules below is the order of the pipeline: a module uses only earlier ones.

pub mod error;
pub mod diagnostic;
pub mod plan;
pub mod height;
pub mod spectrum;
pub mod optics;
pub mod frame;
pub mod picture;
pub mod transform;
pub mod basis;
pub mod field;
pub mod replicas;
pub mod terms;
pub mod reference;
pub mod tables;
pub mod resolve;
pub mod twin;
pub mod profile;
pub mod template;
pub mod module;
pub mod emit;
pub mod assemble;
pub mod package;
pub mod manifest;
pub mod generate;
pub mod runner;
pub mod validate;
pub mod measure;
