//! Data to stdout, diagnostics to stderr.

use std::io::{self, IsTerminal, Write};

use anyhow::Result;
use diffraction_shaders::diagnostic::{self, Diagnostic, Diagnostics};
use diffraction_shaders::error::Error;

use crate::program::spoken;

/// Form of diagnostics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum MessageFormat {
    /// Lines for people.
    Human,
    /// One JSON object per line.
    Json,
}

/// Where commands speak.
pub struct Console {
    format: MessageFormat,
}

/// Several errors of one cause, such as all faults of a plan; each is told on its own line.
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
    /// With the form of its diagnostics.
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

    /// Tells something worth knowing though nothing is wrong.
    pub fn note(&self, text: &str) {
        let severity = diagnostic::Severity::Note;
        self.tell("note", text, Diagnostic { severity, ..Diagnostic::error(text) });
    }

    /// Tells diagnostics with their places, one for what several variants share.
    pub fn diagnostics(&self, diagnostics: &[Diagnostic]) {
        let format = match self.format {
            MessageFormat::Human => diagnostic::MessageFormat::Human,
            MessageFormat::Json => diagnostic::MessageFormat::Json,
        };
        let grouped = diagnostic::group(diagnostics.to_vec());
        let colour = io::stderr().is_terminal();
        let mut text = Vec::new();
        let _ = diagnostic::write(&grouped, format, colour, &mut text);
        say(&text);
    }

    /// Tells why a command failed, with its causes.
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
                    self.tell("error", &text, Diagnostic::error(text.clone()));
                }
            },
        }
    }

    /// The library's errors tell their sources themselves.
    fn library_error(&self, error: &Error) {
        let plain = Diagnostic::error(error.message());
        let diagnostic = match error.advice() {
            Some(advice) => plain.help(advice),
            None => plain,
        };
        self.tell("error", &error.to_string(), diagnostic);
    }

    fn tell(&self, level: &str, line: &str, diagnostic: Diagnostic) {
        let mut text = Vec::new();
        let _ = match self.format {
            MessageFormat::Human => writeln!(text, "{level}: {line}"),
            MessageFormat::Json => {
                diagnostic::write(&[diagnostic], diagnostic::MessageFormat::Json, false, &mut text)
            }
        };
        say(&text);
    }
}

/// Writes to stderr what names the running program.
fn say(text: &[u8]) {
    let text = String::from_utf8_lossy(text);
    // Nobody is left to tell when stderr is closed.
    let _ = io::stderr().lock().write_all(spoken(&text).as_bytes());
}

/// Whether the reader of stdout went away, as `head` does.
pub fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let kind = error.downcast_ref::<io::Error>().map(io::Error::kind);
    kind == Some(io::ErrorKind::BrokenPipe)
}
