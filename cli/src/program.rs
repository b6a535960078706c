//! The name by which users call the running program.
//!
//! Texts and messages are written for `cargo xtask`; what another program says names that program instead.

use std::borrow::Cow;
use std::sync::OnceLock;

/// The name in texts and messages as they are written.
const WRITTEN: &str = "cargo xtask";

/// The environment variable by which a program tells another one, which takes its place, how it was called.
pub const CALLED_AS: &str = "DIFFRACTION_CALLED_AS";

static NAME: OnceLock<String> = OnceLock::new();

/// Sets the name, once and before anything is said.
pub fn set_name(name: &str) {
    NAME.get_or_init(|| name.to_owned());
}

/// What users type before the name of a command.
pub fn name() -> &'static str {
    NAME.get().map_or(WRITTEN, String::as_str)
}

/// A text as the running program says it.
pub fn spoken(text: &str) -> Cow<'_, str> {
    match name() {
        WRITTEN => Cow::Borrowed(text),
        name => Cow::Owned(text.replace(WRITTEN, name)),
    }
}

/// A command of which every text names the running program.
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
