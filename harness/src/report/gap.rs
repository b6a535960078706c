//! What to say where nothing was recorded.

use maud::{Markup, html};

/// A line instead of a section.
pub(super) fn nothing(what: &str, command: &str) -> Markup {
    html! { p.nothing { "Nothing recorded: " (what) ". " code { (command) } " measures them." } }
}
