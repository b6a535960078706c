//! Maps bytes of generated text to lines of templates.

use naga::Span;

use crate::diagnostic::{Diagnostic, GeneratedLine, Place};
use crate::shader::template::{Sources, Specialised, Words};

/// The origin of every byte of one variant's text.
pub struct Locator<'a> {
    specialised: &'a Specialised,
    sources: &'a Sources,
    variant: &'a str,
}

impl<'a> Locator<'a> {
    /// A locator for the text of `variant`.
    pub fn new(
        specialised: &'a Specialised,
        sources: &'a Sources,
        variant: &'a str,
    ) -> Locator<'a> {
        Locator { specialised, sources, variant }
    }

    /// An error at a span of the generated text. It has no place if the span is undefined.
    pub fn diagnostic(&self, message: impl Into<String>, span: Span) -> Diagnostic {
        let mut diagnostic = Diagnostic::error(message).variant(self.variant);
        if let Some((place, generated)) = self.place(span) {
            diagnostic.primary = Some(place);
            diagnostic.secondary = Some(generated);
        }
        diagnostic
    }

    /// Template place and generated line of the beginning of a span.
    pub fn place(&self, span: Span) -> Option<(Place, GeneratedLine)> {
        let text = &self.specialised.text;
        let offset = span.to_range()?.start.min(text.len());
        let before = text.get(..offset)?;
        let index = before.matches('\n').count();
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let column = before[start..].chars().count() as u32 + 1;
        // a span at the end of the text is after the last line
        let origin = self.specialised.origins.get(index).or(self.specialised.origins.last())?;
        let line = text.lines().nth(index).unwrap_or_default();
        let mut place = self.sources.place(&origin.file, origin.line, column);
        if place.text.trim_end() != line {
            // in a generated declaration, the column has no meaning for the template
            place.column = 1;
        }
        Some((place, GeneratedLine { line: index as u32 + 1, text: line.to_owned() }))
    }

    /// Span of a name's declaration: its first occurrence outside comments after a declaring keyword, otherwise its
    /// first occurrence.
    pub fn word(&self, name: &str) -> Span {
        let mut words = Words::default();
        let mut start = 0;
        let mut previous = "";
        let mut first = None;
        for line in self.specialised.text.split_inclusive('\n') {
            for (at, word) in words.of(line) {
                if word == name {
                    let begin = (start + at) as u32;
                    let span = Span::new(begin, begin + name.len() as u32);
                    if DECLARING.contains(&previous) {
                        return span;
                    }
                    first.get_or_insert(span);
                }
                previous = word;
            }
            start += line.len();
        }
        first.unwrap_or_default()
    }
}

const DECLARING: &[&str] = &["alias", "const", "fn", "let", "override", "struct", "var"];
