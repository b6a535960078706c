//! The truth: exact amplitudes and colours against closed forms, definitions and vectors.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod closed_forms;
mod exact_field;
mod matter;
mod orders;
mod reference;
mod rigorous;
mod vectors;
