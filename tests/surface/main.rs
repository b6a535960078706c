//! Heights: readers of files, synthetic surfaces, preparation, inputs.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod height_bad;
mod height_prepare;
mod height_read;
mod height_synthetic;
mod input;
