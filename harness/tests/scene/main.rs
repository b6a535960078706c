//! Bodies with a variant as their skin.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod scene;
mod scene_lights;
mod scene_surroundings;
mod scene_files;
mod mesh_bounds;
