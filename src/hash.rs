//! Hashes of inputs, used as names.

use std::io::{self, Read};

use serde_json::Value;
use sha2::{Digest, Sha256};

/// Version of this tool, a part of every hash of inputs.
pub const TOOL_VERSION: &str = env!("CARGO_PKG_VERSION");

/// SHA-256, hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

pub(crate) fn hex(digest: &[u8]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of everything that a reader returns, hexadecimal. Reads it in parts, to limit memory.
pub fn sha256_of(mut reader: impl Read) -> io::Result<String> {
    let mut hasher = Sha256::new();
    let mut part = vec![0; 1 << 20];
    loop {
        match reader.read(&mut part)? {
            0 => break,
            count => hasher.update(&part[..count]),
        }
    }
    Ok(hex(&hasher.finalize()))
}

/// SHA-256 of a value as one line of JSON, hexadecimal. Floats are written in the shortest form that reads back.
pub fn of_value(value: &Value) -> String {
    sha256(value.to_string().as_bytes())
}
