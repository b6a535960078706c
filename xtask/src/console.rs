//! Data to stdout, diagnostics to stderr.

use std::io::{self, Write};

use anyhow::Result;
use diffraction_shaders::error::Error;

/// Form of diagnostics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum MessageFormat {
    /// Lines for people.
    Human,
    /// One JSON object per line.
    Json,
}

/// Where commands speak.
pub(crate) struct Console {
    format: MessageFormat,
}

/// Several errors of one cause, such as all faults of a plan; each is told on its own line.
#[derive(Debug)]
pub(crate) struct Errors(pub(crate) Vec<Error>);

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let lines: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&lines.join("\n"))
    }
}

impl std::error::Error for Errors {}

impl Console {
    pub(crate) fn new(format: MessageFormat) -> Console {
        Console { format }
    }

    /// Writes data to stdout.
    pub(crate) fn data(&self, text: &str) -> Result<()> {
        let mut stdout = io::stdout().lock();
        stdout.write_all(text.as_bytes())?;
        stdout.flush()?;
        Ok(())
    }

    /// Tells something worth knowing though nothing is wrong.
    pub(crate) fn note(&self, text: &str) {
        self.tell("note", text);
    }

    /// Tells why a command failed, with its causes.
    pub(crate) fn error(&self, error: &anyhow::Error) {
        match error.downcast_ref::<Errors>() {
            Some(Errors(errors)) => {
                errors.iter().for_each(|error| self.tell("error", &error.to_string()))
            }
            // The library's errors tell their sources themselves.
            None if error.downcast_ref::<Error>().is_some() => {
                self.tell("error", &error.to_string())
            }
            None => self.tell("error", &format!("{error:#}")),
        }
    }

    fn tell(&self, level: &str, text: &str) {
        let line = match self.format {
            MessageFormat::Human => format!("{level}: {text}\n"),
            MessageFormat::Json => {
                format!("{}\n", serde_json::json!({ "level": level, "message": text }))
            }
        };
        // Nobody is left to tell when stderr is closed.
        let _ = io::stderr().write_all(line.as_bytes());
    }
}

/// Whether the reader of stdout went away, as `head` does.
pub(crate) fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let kind = error.downcast_ref::<io::Error>().map(io::Error::kind);
    kind == Some(io::ErrorKind::BrokenPipe)
}
