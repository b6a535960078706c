//! The name of the running program, as users type it.
//!
//! Texts and messages in the sources say `cargo xtask`. Another program replaces that by its own name when it prints them.

use std::borrow::Cow;
use std::sync::OnceLock;

/// The name in texts and messages of the sources.
const WRITTEN: &str = "cargo xtask";

/// The environment variable that passes this name to the program that replaces the running one.
pub const CALLED_AS: &str = "DIFFRACTION_CALLED_AS";

static NAME: OnceLock<String> = OnceLock::new();

/// Sets the name. Call it once, before anything is printed.
pub fn set_name(name: &str) {
    NAME.get_or_init(|| name.to_owned());
}

/// What users type before the name of a command.
pub fn name() -> &'static str {
    NAME.get().map_or(WRITTEN, String::as_str)
}

/// A text of the sources, with the running program's name in it.
pub fn spoken(text: &str) -> Cow<'_, str> {
    match name() {
        WRITTEN => Cow::Borrowed(text),
        name => Cow::Owned(text.replace(WRITTEN, name)),
    }
}

/// A command with the running program's name in all its texts.
pub fn named(command: clap::Command) -> clap::Command {
    texts(command.name(name()).bin_name(name()))
}

fn texts(mut command: clap::Command) -> clap::Command {
    let spoken = |text: &clap::builder::StyledStr| spoken(&text.to_string()).into_owned();
    if let Some(text) = command.get_about().map(spoken) {
        command = command.about(text);
    }
    if let Some(text) = command.get_long_about().map(spoken) {
        command = command.long_about(text);
    }
    if let Some(text) = command.get_after_help().map(spoken) {
        command = command.after_help(text);
    }
    command = command.mut_args(|mut arg| {
        if let Some(text) = arg.get_help().map(spoken) {
            arg = arg.help(text);
        }
        if let Some(text) = arg.get_long_help().map(spoken) {
            arg = arg.long_help(text);
        }
        arg
    });
    command.mut_subcommands(texts)
}
