//! Height fields of the format Gwyddion Simple Field.
#![no_main]

mod reader;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| reader::read("fuzz.gsf", &[reader::FLOATS], bytes));
