//! Runners of shaders in a browser. A binary of its own: two browsers beside other drivers run into their limits of time.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod browser;
mod browser_faults;
mod browser_folders;
