//! Target languages, with their words in plans.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

use super::item::suggest;
use super::words::{Words, names, word_of};

/// A target language.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Target {
    /// WGSL.
    #[serde(rename = "wgsl")]
    Wgsl,
    /// Desktop GLSL 4.50.
    #[serde(rename = "glsl450")]
    Glsl450,
    /// GLSL ES 3.00 (WebGL2).
    #[serde(rename = "glsl-es300")]
    GlslEs300,
    /// SPIR-V 1.0.
    #[serde(rename = "spirv")]
    Spirv,
    /// HLSL, shader model 5.1.
    #[serde(rename = "hlsl")]
    Hlsl,
    /// Metal Shading Language 2.0.
    #[serde(rename = "msl")]
    Msl,
}

pub(super) const TARGETS: Words<Target> = &[
    ("wgsl", Target::Wgsl),
    ("glsl450", Target::Glsl450),
    ("glsl-es300", Target::GlslEs300),
    ("spirv", Target::Spirv),
    ("hlsl", Target::Hlsl),
    ("msl", Target::Msl),
];

impl Target {
    /// Every language that this version emits, in the order of the manual.
    pub fn all() -> Vec<Target> {
        TARGETS.iter().map(|(_, target)| *target).collect()
    }

    /// The language's word in plans and in `--target`.
    pub fn as_str(self) -> &'static str {
        word_of(TARGETS, self)
    }

    /// Reads one word of `--target`.
    pub fn parse(word: &str) -> Result<Target> {
        let found = TARGETS.iter().find(|(known, _)| *known == word);
        found.map(|(_, target)| *target).ok_or_else(|| {
            Error::new(format!("target \"{word}\""), "is unknown")
                .remedy(suggest(word, &names(TARGETS)))
        })
    }
}
