//! How variants compute: every mode's twin against the exact reference.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod adaptive;
mod baked;
mod environment;
mod gems;
mod judged;
mod matter;
mod mesh_frame;
mod modes;
mod orders;
mod path;
mod pattern;
mod pq;
mod prefiltered;
mod quantised;
mod spread;
mod wide_lights;
