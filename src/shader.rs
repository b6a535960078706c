//! The text of a variant: templates specialised, parsed, judged and written in every language.

pub mod limits;
pub mod template;
pub mod module;
pub mod emit;
pub mod specialise;
