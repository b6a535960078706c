//! Findings with a place, grouped over variants, written as text for people or as JSON lines.

mod render;

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt, io,
    str::FromStr,
};

use serde::Serialize;

use crate::error::{Error, Result};

/// How grave a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The output cannot be made or must not be used.
    Error,
    /// The output is made, but the user should look.
    Warning,
    /// For information.
    Note,
}

/// A place in a text file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Place {
    /// Path as shown to the user.
    pub file: String,
    /// Line, counted from 1.
    pub line: u32,
    /// Column in characters, counted from 1.
    pub column: u32,
    /// That line, without its end.
    pub text: String,
}

/// A line of generated text.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct GeneratedLine {
    /// Line, counted from 1.
    pub line: u32,
    /// That line, without its end.
    pub text: String,
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// How grave it is.
    pub severity: Severity,
    /// What is wrong: lower case, without a full stop.
    pub message: String,
    /// Where it is wrong, in a file that a person wrote.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub primary: Option<Place>,
    /// The matching line in the generated text of the first variant that has the finding.
    #[serde(rename = "generated", skip_serializing_if = "Option::is_none")]
    pub secondary: Option<GeneratedLine>,
    /// Further facts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// What to do about it, if that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
    /// The variants that have it.
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    pub variants: BTreeSet<String>,
}

impl Diagnostic {
    /// An error without a place.
    pub fn error(message: impl Into<String>) -> Diagnostic {
        Diagnostic {
            severity: Severity::Error,
            message: message.into(),
            primary: None,
            secondary: None,
            notes: Vec::new(),
            help: None,
            variants: BTreeSet::new(),
        }
    }

    /// A warning without a place.
    pub fn warning(message: impl Into<String>) -> Diagnostic {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::error(message) }
    }

    /// Adds the place.
    #[must_use]
    pub fn at(mut self, place: Place) -> Diagnostic {
        self.primary = Some(place);
        self
    }

    /// Adds a further fact.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Diagnostic {
        self.notes.push(note.into());
        self
    }

    /// The finding with every text changed by a function, such as one that escapes.
    #[must_use]
    pub fn with_text(mut self, change: impl Fn(&str) -> String) -> Diagnostic {
        self.message = change(&self.message);
        self.notes.iter_mut().for_each(|note| *note = change(note));
        self.help = self.help.as_deref().map(change);
        self
    }

    /// Adds what to do about it.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Diagnostic {
        self.help = Some(help.into());
        self
    }

    /// Adds a variant that has the finding.
    #[must_use]
    pub fn variant(mut self, name: impl Into<String>) -> Diagnostic {
        self.variants.insert(name.into());
        self
    }
}

impl From<&Error> for Diagnostic {
    fn from(error: &Error) -> Diagnostic {
        let diagnostic = Diagnostic::error(error.message());
        match error.advice() {
            Some(advice) => diagnostic.help(advice),
            None => diagnostic,
        }
    }
}

impl From<Error> for Diagnostic {
    fn from(error: Error) -> Diagnostic {
        Diagnostic::from(&error)
    }
}

/// Everything that is wrong with one input, as an error: each finding on a line of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines: Vec<&str> = self.0.iter().map(|d| d.message.as_str()).collect();
        f.write_str(&lines.join("\n"))
    }
}

impl std::error::Error for Diagnostics {}

impl From<Vec<Diagnostic>> for Diagnostics {
    fn from(all: Vec<Diagnostic>) -> Diagnostics {
        Diagnostics(all)
    }
}

impl From<Vec<Error>> for Diagnostics {
    fn from(all: Vec<Error>) -> Diagnostics {
        Diagnostics(all.iter().map(Diagnostic::from).collect())
    }
}

impl From<Error> for Diagnostics {
    fn from(error: Error) -> Diagnostics {
        Diagnostics(vec![Diagnostic::from(error)])
    }
}

/// Merges findings that differ only in their variants, generated lines and naga's handle numbers.
///
/// Findings keep the order in which each first occurs, and the notes and generated line of that first one.
pub fn group(diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let mut grouped: Vec<Diagnostic> = Vec::new();
    let mut seen = BTreeMap::new();
    for diagnostic in diagnostics {
        let key = (
            diagnostic.severity,
            without_handles(&diagnostic.message),
            diagnostic.primary.clone(),
            diagnostic.help.clone(),
        );
        let index = *seen.entry(key).or_insert(grouped.len());
        match grouped.get_mut(index) {
            Some(first) => first.variants.extend(diagnostic.variants),
            None => grouped.push(diagnostic),
        }
    }
    grouped
}

/// How diagnostics are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageFormat {
    /// With an excerpt of the source.
    Human,
    /// One JSON object per line.
    Json,
}

impl FromStr for MessageFormat {
    type Err = Error;

    fn from_str(text: &str) -> Result<MessageFormat> {
        match text {
            "human" => Ok(MessageFormat::Human),
            "json" => Ok(MessageFormat::Json),
            other => {
                Err(Error::new(other, "is not a message format").remedy("use `human` or `json`"))
            }
        }
    }
}

/// Writes diagnostics, in their order.
///
/// `colour` also allows box-drawing characters: pass it only for a terminal. JSON is never coloured.
pub fn write(
    diagnostics: &[Diagnostic],
    format: MessageFormat,
    colour: bool,
    out: &mut dyn io::Write,
) -> io::Result<()> {
    for diagnostic in diagnostics {
        match format {
            MessageFormat::Human => render::human(diagnostic, colour, out)?,
            MessageFormat::Json => {
                serde_json::to_writer(&mut *out, diagnostic)?;
                out.write_all(b"\n")?;
            }
        }
    }
    Ok(())
}

/// Naga prints handles as `[12]`; the number differs between variants of the same text.
fn without_handles(message: &str) -> String {
    let mut plain = String::with_capacity(message.len());
    let mut rest = message;
    while let Some(start) = rest.find('[') {
        let (before, bracket) = rest.split_at(start);
        plain.push_str(before);
        let digits = bracket[1..].bytes().take_while(u8::is_ascii_digit).count();
        if digits > 0 && bracket[1 + digits..].starts_with(']') {
            plain.push_str("[_]");
            rest = &bracket[digits + 2..];
        } else {
            plain.push('[');
            rest = &bracket[1..];
        }
    }
    plain + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(line: u32) -> Place {
        Place {
            file: "templates/full.wgsl".into(),
            line,
            column: 5,
            text: "let x = wrong + 1;".into(),
        }
    }

    fn human(diagnostic: Diagnostic) -> String {
        let mut out = Vec::new();
        write(&[diagnostic], MessageFormat::Human, false, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn the_same_error_of_three_variants_is_one() {
        let make = |name: &str, line| {
            let mut d = Diagnostic::error(format!("bad operand [{line}]")).at(at(7)).variant(name);
            d.secondary = Some(GeneratedLine { line, text: String::new() });
            d
        };
        let other = Diagnostic::error("bad operand [1]").at(at(8)).variant("c");
        let grouped = group(vec![make("b", 10), make("a", 20), other.clone(), make("c", 30)]);
        assert_eq!(grouped.len(), 2);
        assert_eq!(grouped[0].variants, ["a", "b", "c"].map(String::from).into());
        assert_eq!(grouped[0].secondary.as_ref().map(|s| s.line), Some(10));
        assert_eq!(grouped[1], other);
    }

    #[test]
    fn people_see_the_line() {
        let mut diagnostic = Diagnostic::error("no definition of `wrong`")
            .at(Place { column: 9, ..at(41) })
            .help("declare it")
            .variant("full-a")
            .variant("full-b");
        diagnostic.secondary = Some(GeneratedLine { line: 99, text: "other text".into() });
        let text = human(diagnostic);
        for part in [
            "error: no definition of `wrong`",
            "templates/full.wgsl:41:9",
            "41 | let x = wrong + 1;",
            "^^^^^",
            "99 | other text",
            "help: declare it",
            "variants: full-a, full-b",
        ] {
            assert!(text.contains(part), "{part:?} is not in\n{text}");
        }
        assert!(text.is_ascii() && !text.contains('\u{1b}'), "{text}");
    }

    #[test]
    fn colour_only_when_asked_for() {
        let mut out = Vec::new();
        let diagnostic = Diagnostic::error("x").at(at(1));
        write(&[diagnostic], MessageFormat::Human, true, &mut out).unwrap();
        assert!(out.contains(&0x1b));
    }

    #[test]
    fn places_outside_the_text_do_no_harm() {
        for column in [0, 1, 19, 400] {
            human(Diagnostic::error("x").at(Place { column, ..at(1) }));
            human(Diagnostic::error("x").at(Place { column, text: "é²".into(), ..at(0) }));
            human(Diagnostic::error("x").at(Place { column, text: String::new(), ..at(0) }));
        }
    }

    #[test]
    fn plain_errors_take_the_same_way() {
        let error = Error::new("plan.toml", "no surface")
            .source(io::Error::other("deeper"))
            .remedy("add one");
        assert_eq!(error.to_string(), "plan.toml: no surface: deeper (add one)");
        let diagnostic = Diagnostic::from(error);
        let mut out = Vec::new();
        write(std::slice::from_ref(&diagnostic), MessageFormat::Json, true, &mut out).unwrap();
        assert_eq!(
            String::from_utf8(out).unwrap(),
            "{\"severity\":\"error\",\"message\":\"plan.toml: no surface: deeper\",\"help\":\"add one\"}\n"
        );
        assert!(human(diagnostic).starts_with("error: plan.toml: no surface: deeper"));
    }

    #[test]
    fn json_has_every_part() {
        let mut diagnostic = Diagnostic::warning("m").at(at(3)).note("n").variant("v");
        diagnostic.secondary = Some(GeneratedLine { line: 9, text: "g".into() });
        let value = serde_json::to_value(&diagnostic).unwrap();
        let expected = serde_json::json!({
            "severity": "warning", "message": "m", "notes": ["n"], "variants": ["v"],
            "primary": {"file": "templates/full.wgsl", "line": 3, "column": 5, "text": "let x = wrong + 1;"},
            "generated": {"line": 9, "text": "g"},
        });
        assert_eq!(value, expected);
    }
}
