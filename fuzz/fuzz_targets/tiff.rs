//! Height fields of the format TIFF.
#![no_main]

mod reader;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| reader::read("fuzz.tiff", &[reader::INTEGERS, reader::FLOATS], bytes));
