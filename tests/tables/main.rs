//! What shaders read: bases, packing, containers, names.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod basis;
mod containers;
mod packing;
mod table_ids;
