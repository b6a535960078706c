//! External validators.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod validate;
mod belief;
mod metal;
mod reflection;
