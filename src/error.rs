//! The only error type of the library: what failed, on what, why, and what to do about it.

use std::fmt;
use std::path::Path;

/// Shorthand for results of this library.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// A path as one word of a command that a message prints for copying. It means this path in every shell, whatever the name has:
/// spaces, quotes, `$`. A leading dash would be an option, so such a path gets `./` before it. A name with control characters is
/// written as `$'…'`, which bash and zsh read.
pub fn shell_path(path: &Path) -> String {
    let text = path.to_string_lossy();
    let text = if text.starts_with('-') { format!("./{text}") } else { text.into_owned() };
    // those that command a terminal, and those that turn the direction of a text
    let is_hidden = |c: char| {
        c.is_control()
            || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(is_hidden)
        && let Ok(word) = shlex::try_quote(&text)
    {
        return word.into_owned();
    }
    let mut word = String::from("$'");
    for c in text.chars() {
        match c {
            '\'' | '\\' => word.extend(['\\', c]),
            c if is_hidden(c) => word += &format!("\\u{:04x}", u32::from(c)),
            c => word.push(c),
        }
    }
    word + "'"
}

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

#[cfg(test)]
mod tests {
    use super::*;

    /// A shell reads every path back as it was.
    #[cfg(unix)]
    #[test]
    fn a_path_in_a_command_is_one_word_of_a_shell() {
        for name in [
            "plain/plan.toml",
            "a b",
            "it's",
            "say \"x\"",
            "$HOME",
            "`id`",
            "a;b&c|d",
            "*?[x]",
            "~",
            "#x",
            "!x",
            "a\\b",
            "-rf",
            "--out",
            "(x)",
            "{a,b}",
            "a\nb",
            "\u{1b}[2J",
            "x\u{202e}y",
            "",
            "grüner Käfer",
        ] {
            let word = shell_path(Path::new(name));
            let said = std::process::Command::new("bash")
                .args(["-c", &format!("export LC_ALL=C.UTF-8; printf '%s|' {word}")])
                .output()
                .expect("bash runs");
            let wanted = if name.starts_with('-') { format!("./{name}") } else { name.to_owned() };
            assert_eq!(String::from_utf8_lossy(&said.stdout), format!("{wanted}|"), "{word}");
            assert!(!word.contains(['\n', '\u{1b}', '\u{202e}']), "{word:?}");
        }
        assert_eq!(shell_path(Path::new("target/out")), "target/out");
    }
}
