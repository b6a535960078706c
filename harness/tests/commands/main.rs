//! The commands of the program, as processes.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod command_bench;
mod command_compare;
mod command_report;
mod command_testbench;
mod command_tune;
mod command_validate;
mod program;
