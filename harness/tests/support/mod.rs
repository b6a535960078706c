//! What tests of the harness share. Each binary uses a part of it.

#![allow(dead_code, reason = "each binary uses a part")]

pub mod again;
pub mod browser;
pub mod passthrough;
pub mod report;
pub mod validators;
pub mod tools;

#[path = "../../../tests/support/data.rs"]
pub mod data;
#[path = "../../../tests/support/package.rs"]
pub mod package;
