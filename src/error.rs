//! The only error type of the library: what failed, on what, why, and what to do about it.

use std::fmt;

/// Shorthand for results of this library.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of the library: subject (a file, a key, a variant), cause, and a remedy where one is known.
///
/// Displays as `subject: cause (remedy)` on one line.
pub struct Error(Box<Inner>);

struct Inner {
    subject: String,
    cause: String,
    remedy: Option<String>,
    source: Option<Box<dyn std::error::Error + Send + Sync>>,
    is_finding: bool,
}

impl Error {
    /// `subject` names the file, key or variant; `cause` is lower case without a full stop.
    pub fn new(subject: impl fmt::Display, cause: impl fmt::Display) -> Error {
        Error(Box::new(Inner {
            subject: subject.to_string(),
            cause: cause.to_string(),
            remedy: None,
            source: None,
            is_finding: false,
        }))
    }

    /// Adds what the user can do about it.
    #[must_use]
    pub fn remedy(mut self, remedy: impl fmt::Display) -> Error {
        self.0.remedy = Some(remedy.to_string());
        self
    }

    /// Adds the underlying error of another library or of the operating system.
    #[must_use]
    pub fn source(mut self, source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Error {
        self.0.source = Some(source.into());
        self
    }

    /// Marks it as a finding: the work was done, and found something wrong. Programs exit with 1 instead of 2.
    #[must_use]
    pub fn finding(mut self) -> Error {
        self.0.is_finding = true;
        self
    }

    /// Whether it is a finding.
    pub fn is_finding(&self) -> bool {
        self.0.is_finding
    }

    /// The file, key or variant that the error is about.
    pub fn subject(&self) -> &str {
        &self.0.subject
    }

    /// `subject: cause` and the source error, without the remedy.
    pub fn message(&self) -> String {
        let Inner { subject, cause, source, .. } = &*self.0;
        match source {
            Some(source) => format!("{subject}: {cause}: {source}"),
            None => format!("{subject}: {cause}"),
        }
    }

    /// What the user can do about it, if that is known.
    pub fn advice(&self) -> Option<&str> {
        self.0.remedy.as_deref()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message())?;
        if let Some(remedy) = &self.0.remedy {
            write!(f, " ({remedy})")?;
        }
        Ok(())
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.0.source.as_deref().map(|e| e as _)
    }
}
