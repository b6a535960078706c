//! The commands of the program, as processes.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

mod bad_input;
mod committed;
mod endless;
mod explain;
mod inspect;
mod lights;
mod list;
mod material;
mod matter;
mod memory;
mod outputs;
mod pattern;
mod program;
mod studio;
mod surfaces;
mod surroundings;
