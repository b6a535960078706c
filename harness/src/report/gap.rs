//! A note in place of a section without records.

use maud::{Markup, html};

/// The note.
pub(super) fn nothing(what: &str, command: &str) -> Markup {
    html! { p.nothing { "Nothing recorded: " (what) ". Measure with " code { (command) } "." } }
}
