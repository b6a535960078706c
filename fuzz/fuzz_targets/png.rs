//! Height fields of the format PNG.
#![no_main]

mod reader;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| reader::read("fuzz.png", &[reader::INTEGERS], bytes));
