//! The rules of the repository: rooms, dependencies, unsafe code, twins of templates.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

mod module_order;
mod repository;
mod twins;
mod graph;
