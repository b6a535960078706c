//! Runners of shaders on the drivers of this machine.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod gpu;
mod checked;
mod egl;
mod passthrough;
mod shader_against_twin;
mod pattern;
mod spread;
mod engine_forms;
