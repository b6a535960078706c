//! Heights: readers of files, synthetic surfaces, preparation, inputs.

#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

#[path = "../support/mod.rs"]
mod support;

mod file_keys;
mod height_bad;
mod height_prepare;
mod height_read;
mod height_synthetic;
mod hostile_files;
mod input;
mod same_heights;
mod stated_pictures;
mod stated_text;
mod text_blocks;
mod text_layouts;
mod text_tables;
mod void_marks;
