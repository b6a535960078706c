//! Packages: compiling, bindings, schemas, writing, determinism.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod bindings;
mod compiler;
mod determinism;
mod outputs;
mod package;
mod schemas;
