//! Hashes that name things by what they are made from.

use serde_json::Value;
use sha2::{Digest, Sha256};

/// Version of this tool, a part of every hash of inputs.
pub const TOOL_VERSION: &str = env!("CARGO_PKG_VERSION");

/// SHA-256, hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a value as one line of JSON, hexadecimal. Floats are written in the shortest form that reads back.
pub fn of_value(value: &Value) -> String {
    sha256(value.to_string().as_bytes())
}
