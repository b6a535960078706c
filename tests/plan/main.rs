//! Plans: reading, refusing, naming, their manual.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod lights;
mod plan;
mod plan_hostile;
mod plan_manual;
mod plan_surfaces;
mod random_plans;
mod fuzz_seeds;
