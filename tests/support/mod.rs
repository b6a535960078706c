//! What tests share. Each binary uses a part of it.

#![allow(dead_code, reason = "each binary uses a part")]

pub mod data;
pub mod heights;
pub mod package;
pub mod random;
pub mod schemas;
pub mod words;
