//! Height fields of the format OpenEXR.
#![no_main]

mod reader;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| reader::read("fuzz.exr", &[reader::FLOATS], bytes));
