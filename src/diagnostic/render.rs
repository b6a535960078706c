//! Diagnostics for people, with `codespan-reporting`.

use std::{io, ops::Range};

use codespan_reporting::{
    diagnostic::{Diagnostic as Report, Label, Severity as Level},
    files::{self, Files},
    term::{
        self, Chars, Config,
        termcolor::{Ansi, NoColor},
    },
};

use super::{Diagnostic, Place, Severity};

/// Maximum number of variants that are named; the others are only counted.
const VARIANTS_NAMED: usize = 8;

/// Writes one diagnostic, followed by an empty line.
pub fn human(diagnostic: &Diagnostic, colour: bool, out: &mut dyn io::Write) -> io::Result<()> {
    let mut excerpts = Excerpts(Vec::new());
    let mut labels = Vec::new();
    let mut notes = diagnostic.notes.clone();
    if let Some(place) = &diagnostic.primary {
        labels
            .push(Label::primary(excerpts.add(&place.file, place.line, &place.text), mark(place)));
    }
    if let Some(generated) = &diagnostic.secondary {
        let same = diagnostic.primary.as_ref().is_some_and(|p| p.text == generated.text);
        if same || generated.text.trim().is_empty() {
            notes.push(format!("generated line {}", generated.line));
        } else {
            let indent = generated.text.len() - generated.text.trim_start().len();
            let file = excerpts.add("generated text", generated.line, &generated.text);
            labels.push(Label::secondary(file, indent..generated.text.len()));
        }
    }
    notes.extend(diagnostic.help.iter().map(|help| format!("help: {help}")));
    notes.extend(variants(diagnostic));
    let report = Report::new(match diagnostic.severity {
        Severity::Error => Level::Error,
        Severity::Warning => Level::Warning,
        Severity::Note => Level::Note,
    })
    .with_message(&diagnostic.message)
    .with_labels(labels)
    .with_notes(notes);
    let chars = if colour { Chars::box_drawing() } else { Chars::ascii() };
    let config = Config { chars, ..Config::default() };
    if colour {
        term::emit_to_write_style(&mut Ansi::new(out), &config, &excerpts, &report)
    } else {
        term::emit_to_write_style(&mut NoColor::new(out), &config, &excerpts, &report)
    }
    .map_err(io::Error::other)
}

/// `variants: a, b and 12 more`.
fn variants(diagnostic: &Diagnostic) -> Option<String> {
    let names: Vec<&str> = diagnostic.variants.iter().map(String::as_str).collect();
    match names.len() {
        0 => None,
        1 => Some(format!("variant: {}", names[0])),
        n if n <= VARIANTS_NAMED => Some(format!("variants: {}", names.join(", "))),
        n => Some(format!(
            "variants: {} and {} more",
            names[..VARIANTS_NAMED].join(", "),
            n - VARIANTS_NAMED
        )),
    }
}

/// Range of bytes to underline: the word, or else the single character, at the place's column.
fn mark(place: &Place) -> Range<usize> {
    let skipped = place.column.saturating_sub(1) as usize;
    let start = place.text.char_indices().nth(skipped).map_or(place.text.len(), |(at, _)| at);
    let rest = &place.text[start..];
    let word = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
    let length = if word > 0 { word } else { rest.chars().next().map_or(0, char::len_utf8) };
    start..start + length
}

/// Single lines, each with its line number in its file.
struct Excerpts<'a>(Vec<(&'a str, usize, &'a str)>);

impl<'a> Excerpts<'a> {
    fn add(&mut self, file: &'a str, line: u32, text: &'a str) -> usize {
        // lines count from 1; the renderer panics at 0
        self.0.push((file, line.max(1) as usize, text));
        self.0.len() - 1
    }

    fn get(&self, id: usize) -> Result<(&'a str, usize, &'a str), files::Error> {
        self.0.get(id).copied().ok_or(files::Error::FileMissing)
    }
}

impl<'a> Files<'a> for Excerpts<'a> {
    type FileId = usize;
    type Name = &'a str;
    type Source = &'a str;

    fn name(&'a self, id: usize) -> Result<&'a str, files::Error> {
        self.get(id).map(|(name, ..)| name)
    }

    fn source(&'a self, id: usize) -> Result<&'a str, files::Error> {
        self.get(id).map(|(_, _, text)| text)
    }

    fn line_index(&'a self, _: usize, _: usize) -> Result<usize, files::Error> {
        Ok(0)
    }

    fn line_number(&'a self, id: usize, index: usize) -> Result<usize, files::Error> {
        self.get(id).map(|(_, line, _)| line + index)
    }

    fn line_range(&'a self, id: usize, index: usize) -> Result<Range<usize>, files::Error> {
        let (_, _, text) = self.get(id)?;
        if index > 0 {
            return Err(files::Error::LineTooLarge { given: index, max: 0 });
        }
        Ok(0..text.len())
    }
}
