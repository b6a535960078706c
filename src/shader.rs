//! The text of a variant: templates are specialised, parsed, validated and written in every target language.

pub mod limits;
pub mod template;
pub mod module;
pub mod emit;
pub mod specialise;
