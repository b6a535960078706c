//! Height fields of the format NPY.
#![no_main]

mod reader;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| reader::read("fuzz.npy", &[reader::INTEGERS, reader::FLOATS], bytes));
