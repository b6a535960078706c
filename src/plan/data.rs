//! What a plan names and does not contain: a known name, or a file.

use std::fmt;
use std::sync::Arc;

use serde::{Serialize, Serializer};

use crate::hash::sha256;

/// A name, or the path of a file. A plan only names the file; [`crate::input`] reads it and adds its content with
/// [`Data::with_content`].
#[derive(Clone, Debug, PartialEq)]
pub struct Data {
    name: String,
    content: Option<Arc<Content>>,
}

#[derive(Debug, PartialEq)]
struct Content {
    bytes: Vec<u8>,
    /// SHA-256 of the bytes.
    hash: String,
}

impl Data {
    /// A name without content.
    pub fn new(name: impl Into<String>) -> Data {
        Data { name: name.into(), content: None }
    }

    /// The name or path as written in the plan.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The bytes of its file, if they were read.
    pub fn content(&self) -> Option<&[u8]> {
        self.content.as_deref().map(|content| content.bytes.as_slice())
    }

    /// The same with the bytes of its file.
    #[must_use]
    pub fn with_content(self, bytes: Vec<u8>) -> Data {
        let hash = sha256(&bytes);
        Data { content: Some(Arc::new(Content { bytes, hash })), ..self }
    }

    /// Identity of its numbers: its name, or the hash of its file's content.
    pub fn identity(&self) -> &str {
        self.content.as_deref().map_or(&self.name, |content| &content.hash)
    }

    /// Serialises [`Data::identity`] in place of the name, for values whose hash names computed numbers.
    pub fn serialize_identity<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.identity())
    }

    /// `f2` for a plain name. A path keeps its readable part, followed by eight digits of its hash.
    pub(super) fn part(&self) -> String {
        let text = self.name.as_str();
        let plain = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit();
        if !text.is_empty() && text.len() <= 16 && text.chars().all(plain) {
            return text.to_ascii_lowercase();
        }
        let stem = text.rsplit(['/', '\\']).next().unwrap_or(text);
        let stem = stem.split('.').next().unwrap_or(stem).to_ascii_lowercase();
        let readable: String =
            stem.chars().filter(|c| c.is_ascii_alphanumeric()).take(24).collect();
        format!("{readable}-{}", &sha256(text.as_bytes())[..8])
    }
}

impl<T: Into<String>> From<T> for Data {
    fn from(name: T) -> Data {
        Data::new(name)
    }
}

impl Serialize for Data {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name)
    }
}

impl fmt::Display for Data {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}
