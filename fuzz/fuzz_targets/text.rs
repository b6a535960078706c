//! Height fields of the format text matrix.
#![no_main]

mod reader;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| reader::read("fuzz.txt", &[reader::FLOATS], bytes));
