//! Output of the commands: data to stdout, diagnostics to stderr.

use std::io::{self, IsTerminal, Write};

use anyhow::Result;
use diffraction_shaders::diagnostic::{self, Diagnostic, Diagnostics};
use diffraction_shaders::error::Error;

use crate::program::spoken;

/// Format of diagnostics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum MessageFormat {
    /// Text for people.
    Human,
    /// One JSON object per line.
    Json,
}

/// Prints what commands have to say.
pub struct Console {
    format: MessageFormat,
}

/// Several errors of one cause, such as all faults of a plan. Each is printed on its own line.
#[derive(Debug)]
pub struct Errors(pub Vec<Error>);

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let lines: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&lines.join("\n"))
    }
}

impl std::error::Error for Errors {}

impl Console {
    /// A console that prints diagnostics in this format.
    pub fn new(format: MessageFormat) -> Console {
        Console { format }
    }

    /// Writes data to stdout.
    pub fn data(&self, text: &str) -> Result<()> {
        let mut stdout = io::stdout().lock();
        stdout.write_all(text.as_bytes())?;
        stdout.flush()?;
        Ok(())
    }

    /// Prints a note: worth knowing, but not an error.
    pub fn note(&self, text: &str) {
        let severity = diagnostic::Severity::Note;
        self.print("note", text, Diagnostic { severity, ..Diagnostic::error(text) });
    }

    /// Prints diagnostics with their places. Diagnostics that several variants share are printed once.
    pub fn diagnostics(&self, diagnostics: &[Diagnostic]) {
        let format = match self.format {
            MessageFormat::Human => diagnostic::MessageFormat::Human,
            MessageFormat::Json => diagnostic::MessageFormat::Json,
        };
        let shown = diagnostics.iter().cloned().map(|one| one.with_text(escaped));
        let grouped = diagnostic::group(shown.collect());
        let colour = io::stderr().is_terminal();
        let mut text = Vec::new();
        let _ = diagnostic::write(&grouped, format, colour, &mut text);
        say(&text);
    }

    /// Prints why a command failed, with the causes.
    pub fn error(&self, error: &anyhow::Error) {
        if let Some(Diagnostics(diagnostics)) = error.downcast_ref::<Diagnostics>() {
            return self.diagnostics(diagnostics);
        }
        match error.downcast_ref::<Errors>() {
            Some(Errors(errors)) => errors.iter().for_each(|error| self.library_error(error)),
            None => match error.downcast_ref::<Error>() {
                Some(error) => self.library_error(error),
                None => {
                    let text = format!("{error:#}");
                    self.print("error", &text, Diagnostic::error(text.clone()));
                }
            },
        }
    }

    /// Prints an error of the library, whose text includes its causes already.
    fn library_error(&self, error: &Error) {
        let plain = Diagnostic::error(error.message());
        let diagnostic = match error.advice() {
            Some(advice) => plain.help(advice),
            None => plain,
        };
        self.print("error", &error.to_string(), diagnostic);
    }

    fn print(&self, level: &str, line: &str, diagnostic: Diagnostic) {
        let mut text = Vec::new();
        let _ = match self.format {
            MessageFormat::Human => writeln!(text, "{level}: {}", escaped(line)),
            MessageFormat::Json => {
                diagnostic::write(&[diagnostic], diagnostic::MessageFormat::Json, false, &mut text)
            }
        };
        say(&text);
    }
}

/// A text whose control characters are written out, so that a file's name or content cannot command the terminal. Line
/// breaks and tabs stay.
pub fn escaped(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' | '\t' => shown.push(c),
            c if c.is_control() || BIDI.contains(&c) => shown.extend(c.escape_unicode()),
            c => shown.push(c),
        }
    }
    shown
}

/// Characters that turn the direction of a text: what is shown would not be what is there (Unicode Standard Annex #9).
const BIDI: [char; 12] = [
    '\u{061c}', '\u{200e}', '\u{200f}', '\u{202a}', '\u{202b}', '\u{202c}', '\u{202d}', '\u{202e}',
    '\u{2066}', '\u{2067}', '\u{2068}', '\u{2069}',
];

/// Writes to stderr, with the name of the running program in the text.
fn say(text: &[u8]) {
    let text = String::from_utf8_lossy(text);
    // if stderr is closed, nobody is left to read the error
    let _ = io::stderr().lock().write_all(spoken(&text).as_bytes());
}

/// Whether the reader of stdout closed the pipe, as `head` does.
pub fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let kind = error.downcast_ref::<io::Error>().map(io::Error::kind);
    kind == Some(io::ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::escaped;

    #[test]
    fn a_text_cannot_command_the_terminal() {
        for (text, shown) in [
            ("grüner Käfer\n\tµm 漢字", "grüner Käfer\n\tµm 漢字"),
            ("a\u{1b}[2Jb", "a\\u{1b}[2Jb"),
            ("a\rb\u{8}\u{7f}\u{9b}31m", "a\\u{d}b\\u{8}\\u{7f}\\u{9b}31m"),
            ("gpj.\u{202e}nacs", "gpj.\\u{202e}nacs"),
        ] {
            assert_eq!(escaped(text), shown);
        }
    }
}
