//! Strangers that read a package: the gallery and the examples. A binary of its own: it drives browsers and builds a page.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod consumers;
